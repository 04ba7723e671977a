#pragma once

#include <openvdb/openvdb.h>

#include <optional>

namespace vdblic {

/// A rigid or affine map of index spaces: position → matrix · position + shift.
struct IndexMap {
    openvdb::Mat3d matrix = openvdb::Mat3d::identity();
    openvdb::Vec3d shift{0, 0, 0};

    [[nodiscard]] openvdb::Vec3d at(const openvdb::Vec3d& position) const { return matrix * position + shift; }
    /// The voxels whose places may lie in or next to the places of a box; limited to the coordinates of OpenVDB.
    [[nodiscard]] openvdb::CoordBBox around(const openvdb::CoordBBox& box) const;
};

/// A velocity on voxels that lie elsewhere, in its own axes and unit.
///
/// A voxel is active if the nearest voxel of the source is. Its value is trilinear over the active ones of the eight
/// corners (valueAt()): where voxels fall on voxels, exactly theirs. Computed in parallel; the result does not depend
/// on the number of threads.
/// @param toSource from the index space of the result to that of `values`; invertible
/// @param box      whole leaves of the result; those outside get no values (LeafBuffer::empty())
/// @return a grid with the metadata and the transform of `values`, without tiles
/// @throws InputError if the voxels exceed the memory
[[nodiscard]] openvdb::Vec3SGrid::Ptr movedVelocity(const openvdb::Vec3SGrid& values, const IndexMap& toSource,
                                                    const std::optional<openvdb::CoordBBox>& box);

} // namespace vdblic
