#pragma once

#include "vdblic/render/render_sequence.h"

namespace vdblic {

/// What the header of a frame's image says: all that made it.
[[nodiscard]] ImageHeader imageHeader(const RenderParams& params, const Look& look, const Camera& camera,
                                      const FrameFile& file);

} // namespace vdblic
