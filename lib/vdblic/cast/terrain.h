#pragma once

#include <openvdb/openvdb.h>

namespace vdblic {

/// The ground below a domain as a smooth surface, if the inactive voxels of its box are ground: columns that stand on
/// the box's bottom, with steps mostly small beside the range of heights. Bodies with walls are not ground.
///
/// Heights belong to columns of the data's voxels, each several voxels of a refined domain; the surface is
/// their uniform bicubic B-spline. So it has no stairs, and is off by less than a voxel of the data where heights are
/// even. A plate of one such voxel below the box carries it, so that no hill stands alone.
/// @param rest the inactive voxels in the box
/// @param box  around the domain
/// @return a level set in index space with the half width `band` [voxels]; null if it is no ground
[[nodiscard]] openvdb::FloatGrid::Ptr terrainOf(const openvdb::MaskTree& rest, const openvdb::CoordBBox& box, int band);

} // namespace vdblic
