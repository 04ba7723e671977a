#include "vdblic/cast/ground_plane.h"

#include "vdblic/cast/solid.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace vdblic {
namespace {

constexpr double kFade = 1.6; // of the mean half side of the domain's projection

/// From the ground into the domain.
glm::dvec3 inward(GroundSide side, const glm::dvec3& up)
{
    if (side == GroundSide::kBelow) return glm::normalize(up);
    const int wall = int(side) - int(GroundSide::kLowX);
    glm::dvec3 result(0);
    result[wall / 2] = wall % 2 ? -1 : 1;
    return result;
}

/// The lowest point of a solid along a direction.
double lowestOf(const Solid& solid, const glm::dvec3& direction)
{
    double lowest = HUGE_VAL;
    const openvdb::CoordBBox box = boundsOf(solid);
    const glm::dmat4 toWorld = glm::inverse(solid.worldToIndex);
    for (unsigned corner = 0; corner < 8 && !box.empty(); ++corner) {
        glm::dvec4 at(0, 0, 0, 1);
        for (int axis = 0; axis < 3; ++axis)
            at[axis] = corner >> axis & 1 ? box.max()[axis] + 0.5 : box.min()[axis] - 0.5;
        lowest = std::min(lowest, glm::dot(glm::dvec3(toWorld * at), direction));
    }
    return lowest;
}

} // namespace

double GroundPlane::alpha(const glm::dvec2& place) const
{
    const glm::dvec2 beyond = glm::max(glm::abs(place - middle) - half, glm::dvec2(0));
    const double left = std::max(1 - glm::dot(beyond, beyond) / (fade * fade), 0.0);
    return left * left * left;
}

GroundPlane groundPlane(GroundSide side, const glm::dvec3& up, const Corners& box, const Solid* solid)
{
    GroundPlane plane{};
    plane.normal = inward(side, up);
    // Along the world's axes if the normal is along one.
    glm::dvec3 least(0);
    const glm::dvec3 steepness = glm::abs(plane.normal);
    least[steepness.x <= steepness.y && steepness.x <= steepness.z ? 0 : steepness.y <= steepness.z ? 1 : 2] = 1;
    plane.axes[0] = glm::normalize(least - plane.normal * glm::dot(least, plane.normal));
    plane.axes[1] = glm::cross(plane.normal, plane.axes[0]);
    plane.height = HUGE_VAL;
    glm::dvec2 low(HUGE_VAL), high(-HUGE_VAL);
    for (const glm::dvec3& corner : box) {
        plane.height = std::min(plane.height, glm::dot(corner, plane.normal));
        const glm::dvec2 place(glm::dot(corner, plane.axes[0]), glm::dot(corner, plane.axes[1]));
        low = glm::min(low, place);
        high = glm::max(high, place);
    }
    if (solid) plane.height = std::min(plane.height, lowestOf(*solid, plane.normal));
    plane.middle = (low + high) / 2.0;
    plane.half = (high - low) / 2.0;
    plane.fade = kFade * (plane.half.x + plane.half.y) / 2;
    return plane;
}

} // namespace vdblic
