#pragma once

#include "vdblic/camera/camera.h"
#include "vdblic/look/look.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/volume/texture_volume.h"

#include <string>

namespace vdblic {

class Exchange;

/// Why the picture of a volume is empty, with the remedy, for messages.
/// @param rays     with the cuts in the volume's space
/// @param exchange of the ranks that share the volume: collective
[[nodiscard]] std::string whyNothingIsSeen(const TextureVolume& volume, const Look& look, const Camera& camera,
                                           const RayCastParams& rays, Exchange& exchange);

} // namespace vdblic
