#pragma once

#include "vdblic/compare/compare.h"

#include <openvdb/openvdb.h>
#include <openvdb/points/PointDataGrid.h>

namespace vdblic::compare {

/// Compare the points of two grids: by the attribute `id` if both have one of integers, else by their order within
/// each voxel. Every attribute of matched points is compared, the position in world units.
/// @throws InputError naming an attribute that cannot be compared
[[nodiscard]] PointDifference comparePoints(const openvdb::points::PointDataGrid& a,
                                            const openvdb::points::PointDataGrid& b, const CompareParams& params);

} // namespace vdblic::compare
