#pragma once

#include "vdblic/render/render_sequence.h"

namespace vdblic {

/// What the header of a frame's image says: all that made it, in the spelling of the
/// command line where one attribute holds several numbers.
[[nodiscard]] ImageHeader imageHeader(const RenderParams& params, const Look& look, const Camera& camera,
                                      const FrameFile& file);

} // namespace vdblic
