#pragma once

#include "vdblic/cast/ground_light.h"
#include "vdblic/cast/ground_plane.h"

#include <glm/vec3.hpp>

#include <cstdint>

namespace vdblic {

class Camera;
class PlacedBox;
struct Look;
struct SurfacePicture;

/// A plane that takes shadows, and fades out with the distance from the domain. Its colour is the background's in the
/// picture's row, or a lighter one where that is too dark for shadows. Behind all else in a picture, it is seen from
/// the domain's side alone. Immutable; any number of threads may read.
class Ground {
  public:
    Ground(const GroundPlane& plane, const ShadowCasters& casters, const glm::dvec3& towardsLight)
        : mPlane(plane), mLight(plane, casters, towardsLight)
    {
    }

    /// Add the visible ground to pixels that show no surface. @param ray, only as in castSurfaces()
    void addTo(SurfacePicture& picture, const PlacedBox& box, const Look& look, const Camera& camera, int ray,
               const std::uint8_t* only) const;

  private:
    GroundPlane mPlane;
    GroundLight mLight;
};

} // namespace vdblic
