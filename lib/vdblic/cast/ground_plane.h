#pragma once

#include "vdblic/camera/camera.h"
#include "vdblic/cast/ground_side.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace vdblic {

struct Solid;

/// Where a ground lies, in world space: along a side of the box around the domain, or farther out behind a solid that
/// passes this side.
struct GroundPlane {
    glm::dvec3 normal;  ///< towards the domain, of length 1
    glm::dvec3 axes[2]; ///< of the plane's coordinates, of length 1 and perpendicular
    double height;      ///< of the plane along the normal
    glm::dvec2 middle;  ///< of the rectangle around the domain's projection
    glm::dvec2 half;    ///< half the sides of that rectangle
    double fade;        ///< distance from the rectangle at which the ground has faded out

    [[nodiscard]] glm::dvec3 at(const glm::dvec2& place) const
    {
        return normal * height + axes[0] * place.x + axes[1] * place.y;
    }
    /// The ground's opacity: 1 under the domain, 0 from the distance `fade` on, smooth in between.
    [[nodiscard]] double alpha(const glm::dvec2& place) const;
};

/// @param side  other than none  @param up any length but 0  @param solid or null
[[nodiscard]] GroundPlane groundPlane(GroundSide side, const glm::dvec3& up, const Corners& box, const Solid* solid);

} // namespace vdblic
