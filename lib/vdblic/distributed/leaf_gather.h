#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/field/domain.h"
#include "vdblic/io/vdb_assembly.h"
#include "vdblic/io/vdb_file.h"

#include <openvdb/openvdb.h>

namespace vdblic {

/// The leaves of a grid that the ranks compute together, stored for rank 0 to write. Collective.
/// @param grid   has at least the domain's own leaves
/// @return at rank 0 the leaves of all ranks, in the order of the domain's; elsewhere nothing
[[nodiscard]] StoredLeaves gatherLeaves(Exchange& exchange, const Domain& domain, const openvdb::FloatGrid& grid,
                                        VdbCompression compression);

/// A grid with all leaves of a domain and no values, and otherwise as `grid`: to be written with stored leaves.
[[nodiscard]] openvdb::FloatGrid::Ptr withoutValues(const Domain& domain, const openvdb::FloatGrid& grid);

} // namespace vdblic
