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
/// A tube has one alpha wherever a ray enters it: one voxel's under the look's transfer function, with the line's own
/// opacity as the texture's density. It is lit as a surface. A ray that starts inside a tube, at a cut, does not see
/// that tube. The pixels do not depend on the number of threads. Thread-safe.
/// @param tree    of the look
/// @param params  valid
/// @param ray, scenery, only, stop as in castRays()
/// @throws Stopped if a stop was requested
[[nodiscard]] Image castTubes(const TubeTree& tree, const Look& look, const Camera& camera, const RayCastParams& params,
                              int ray = 0, const Scenery& scenery = {}, const std::uint8_t* only = nullptr,
                              const std::stop_token& stop = {});

} // namespace vdblic
