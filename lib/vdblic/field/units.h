#pragma once

#include <openvdb/openvdb.h>

#include <array>
#include <cstddef>

namespace vdblic {

/// \file
/// Spaces and times as types: mixing them does not compile. Kernels take plain numbers.

/// Where lengths are measured: in the texture's voxels, in the velocity's, or in world units. Both are index spaces
/// with voxel centres at integers; without refinement they are the same.
enum class Space { kTexture, kVelocity, kWorld };

/// The time unit of a velocity: a second, the time between two frames, or a step, which is a part of it with substeps.
enum class Per { kSecond, kFrame, kStep };

/// A voxel.
template<Space kSpace>
struct Voxel {
    openvdb::Coord at;
};

/// A box of voxels.
template<Space kSpace>
struct VoxelBox {
    openvdb::CoordBBox voxels;
};

/// Widths around a box, in voxels along each axis.
template<Space kSpace>
struct Rim {
    openvdb::Coord voxels{0, 0, 0};
};

/// A length along each axis.
template<Space kSpace>
struct Lengths {
    std::array<float, 3> along{};
    [[nodiscard]] float operator[](std::size_t axis) const { return along[axis]; }
};

/// The magnitude of a velocity along each axis.
template<Space kSpace, Per kTime>
struct Speeds {
    std::array<float, 3> along{};
    [[nodiscard]] float operator[](std::size_t axis) const { return along[axis]; }
};

/// Matrix from stored velocities to velocities in a space, per time unit.
template<Space kSpace, Per kTime>
struct FromStored {
    openvdb::Mat3d matrix;

    [[nodiscard]] FromStored operator*(double factor) const { return {matrix * factor}; }
};

} // namespace vdblic
