#pragma once

#include "vdblic/cast/surface_picture.h"
#include "vdblic/image/image.h"

#include <cstdint>
#include <stop_token>

namespace vdblic {

class Camera;
class TubeTree;
struct Look;
struct RayCastParams;

/// Cast a ray through each pixel's centre and blend the tubes that it enters, front to back, with early termination.
///
/// A tube takes the same share of the light wherever a ray enters it: that of one voxel under the look's transfer
/// function, with the line's own opacity as the texture's density. It is lit as the surface that it is. Where cuts
/// begin inside of a tube, the tube's rest is not seen. The pixels do not depend on the number of threads. Thread-safe.
/// @param tree    of the look
/// @param params  valid
/// @param ray, scenery, only, stop as those of castRays()
/// @throws Stopped if a stop was requested
[[nodiscard]] Image castTubes(const TubeTree& tree, const Look& look, const Camera& camera, const RayCastParams& params,
                              int ray = 0, const Scenery& scenery = {}, const std::uint8_t* only = nullptr,
                              const std::stop_token& stop = {});

} // namespace vdblic
