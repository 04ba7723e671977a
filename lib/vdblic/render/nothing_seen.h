#pragma once

#include "vdblic/camera/camera.h"
#include "vdblic/look/look.h"
#include "vdblic/render/loaded_texture.h"
#include "vdblic/render/render_plan.h"

#include <string>

namespace vdblic {

class Exchange;

/// Why the picture of a frame is empty, with the remedy, for messages.
/// @param rays     with the cuts in the picture's space
/// @param exchange of the ranks that share the frame: collective
[[nodiscard]] std::string whyNothingIsSeen(const LoadedTexture& frame, const Look& look, const Camera& camera,
                                           const RayCastParams& rays, Exchange& exchange);

} // namespace vdblic
