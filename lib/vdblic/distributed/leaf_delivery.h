#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/distributed/leaf_stream.h"
#include "vdblic/field/domain.h"
#include "vdblic/io/vdb_assembly.h"
#include "vdblic/io/vdb_file.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

/// The stored leaves of a grid that one rank computed, kept until the writing rank takes them.
struct OwnLeaves {
    std::size_t all = 0;                ///< leaves in the whole grid
    std::vector<std::uint32_t> numbers; ///< of the own leaves among them, ascending
    StoredLeaves stored;
};

/// Store a domain's own leaves of a grid. @param grid of float or int32; contains these leaves
[[nodiscard]] OwnLeaves storeOwn(const Domain& domain, const openvdb::GridBase& grid, VdbCompression compression);

/// Deliver the leaves of jointly computed grids to their writers: rank r receives the whole of grid r. Collective.
/// Works in chunks, so no writer holds a whole grid.
/// @param grids  one per writer; writers are the first ranks
/// @param stream receives this rank's grid, in the domain's order; null if this rank does not write
void deliver(Exchange& exchange, std::vector<OwnLeaves> grids, LeafStream* stream);

/// The whole of a jointly computed grid at rank 0; null at the others. Collective.
/// @param grid of float or int32; has this rank's own leaves
[[nodiscard]] openvdb::GridBase::Ptr gathered(Exchange& exchange, const Domain& domain, const openvdb::GridBase& grid);

/// A copy of a grid with all leaves of a domain and no values, to be written with stored leaves.
/// @param grid of float or int32
[[nodiscard]] openvdb::GridBase::Ptr withoutValues(const Domain& domain, const openvdb::GridBase& grid);

} // namespace vdblic
