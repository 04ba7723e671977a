#pragma once

#include "vdblic/cast/ground_light.h"
#include "vdblic/cast/ground_plane.h"

#include <glm/vec3.hpp>

#include <optional>

namespace vdblic {

/// A plane that takes shadows, and fades out with the distance from the domain. Its colour is the background's in the
/// picture's row, or a lighter one where that is too dark for shadows. Behind all else in a picture, it is seen from
/// the domain's side alone. Immutable; any number of threads may read.
class Ground {
  public:
    Ground(const GroundPlane& plane, const ShadowCasters& casters, const glm::dvec3& towardsLight)
        : mPlane(plane), mLight(plane, casters, towardsLight)
    {
    }

    struct Point {
        double depth; ///< multiples of the ray's direction
        float light;  ///< GroundLight::at()
        float alpha;
    };
    /// The point that a ray meets; nullopt if the ground is not seen there.
    [[nodiscard]] std::optional<Point> at(const glm::dvec3& origin, const glm::dvec3& direction) const;
    /// Its colour without shadows, in linear light. @param background of the picture's row
    [[nodiscard]] static glm::vec3 color(const glm::vec3& background);
    [[nodiscard]] glm::vec3 normal() const { return mPlane.normal; }

  private:
    GroundPlane mPlane;
    GroundLight mLight;
};

} // namespace vdblic
