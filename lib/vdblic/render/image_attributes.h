#pragma once

#include "vdblic/image/image_file.h"

namespace vdblic {

class Camera;
struct FrameFile;
struct Look;
struct PicturePlan;

/// The header of a frame's image: all parameters that made it. An attribute of several numbers is spelled as on the
/// command line.
[[nodiscard]] ImageHeader imageHeader(const PicturePlan& plan, const Look& look, const Camera& camera,
                                      const FrameFile& file);

} // namespace vdblic
