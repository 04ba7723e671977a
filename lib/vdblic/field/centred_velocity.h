#pragma once

#include "vdblic/io/velocity_grids.h"

#include <openvdb/openvdb.h>

#include <optional>
#include <string>

namespace vdblic {

/// Convert the grids of a velocity to one grid on voxel centres, in the unit of the source. Double precision is
/// narrowed to single.
///
/// Components are staggered if their grid class says so or if their transforms differ by half a voxel. The value at a
/// voxel centre is then the mean of the two faces; where the far face has no value, the near one stands for both.
/// @param path of the file, for messages
/// @param box  whole leaves; leaves outside may lack values (LeafBuffer::empty()), in `found` and in the result
/// @throws InputError if a transform is a frustum or sheared, the components' transforms do not fit together, or the
///         voxels exceed the memory
[[nodiscard]] openvdb::Vec3SGrid::Ptr centredVelocity(const VelocityGrids& found, const std::string& path,
                                                      const std::optional<openvdb::CoordBBox>& box = std::nullopt);

/// A velocity of zeros. @param topology without tiles  @param box leaves outside get no values (LeafBuffer::empty())
[[nodiscard]] openvdb::Vec3SGrid::Ptr zeroVelocity(const openvdb::MaskTree& topology,
                                                   const std::optional<openvdb::CoordBBox>& box);

} // namespace vdblic
