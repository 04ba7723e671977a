#pragma once

#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>

namespace vdblic {

/// Whether each place in world space is at one finite place in index space.
[[nodiscard]] inline bool isInvertible(const openvdb::math::Transform& transform)
{
    constexpr double kFlat = 1e-12; // relative to the longest side, and to the product of the sides
    const openvdb::Vec3d sides = transform.voxelSize(), origin = transform.indexToWorld(openvdb::Vec3d(0));
    const double longest = std::max({sides[0], sides[1], sides[2]}), volume = transform.baseMap()->determinant();
    return std::isfinite(longest) && std::min({sides[0], sides[1], sides[2]}) > kFlat * longest &&
           std::abs(volume) > kFlat * sides[0] * sides[1] * sides[2] && std::isfinite(origin[0]) &&
           std::isfinite(origin[1]) && std::isfinite(origin[2]);
}

} // namespace vdblic
