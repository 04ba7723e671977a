#pragma once

#include <openvdb/math/Coord.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace vdblic {

/// Largest magnitude of a voxel's index: the extents of all boxes then fit into 32 bits.
inline constexpr int kFarthestIndex = 1'000'000'000;

/// The voxels of a box along each axis; 0 if it is empty. openvdb::CoordBBox::dim() overflows on hostile boxes.
[[nodiscard]] inline std::array<std::int64_t, 3> extentOf(const openvdb::CoordBBox& box)
{
    if (box.empty()) return {};
    std::array<std::int64_t, 3> extent{};
    for (int axis = 0; axis < 3; ++axis)
        extent[std::size_t(axis)] = std::int64_t(box.max()[axis]) - box.min()[axis] + 1;
    return extent;
}

/// The number of voxels in a box. openvdb::CoordBBox::volume() overflows on hostile boxes.
[[nodiscard]] inline double voxelsOf(const openvdb::CoordBBox& box)
{
    const auto [x, y, z] = extentOf(box);
    return double(x) * double(y) * double(z);
}

} // namespace vdblic
