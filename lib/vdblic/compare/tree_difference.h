#pragma once

#include "vdblic/compare/compare.h"

#include <openvdb/openvdb.h>

namespace vdblic::compare {

/// Compare the values, the topology and the backgrounds of two grids of one type.
///
/// For the types of GridTypes (grid_types.h). Sets `values` and `background` of the result.
template<typename GridT>
void compareTrees(const GridT& a, const GridT& b, const CompareParams& params, GridDifference& result);

} // namespace vdblic::compare
