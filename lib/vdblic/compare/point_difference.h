#pragma once

#include "vdblic/compare/compare.h"

#include <openvdb/openvdb.h>
#include <openvdb/points/PointDataGrid.h>

namespace vdblic::compare {

/// Compare the points of two grids.
///
/// Points are matched by the integer attribute `id` if both grids have it, else by their order within each voxel. All
/// attributes of matched points are compared; positions in world units.
/// @throws InputError naming an attribute that cannot be compared
[[nodiscard]] PointDifference comparePoints(const openvdb::points::PointDataGrid& a,
                                            const openvdb::points::PointDataGrid& b, const CompareParams& params);

} // namespace vdblic::compare
