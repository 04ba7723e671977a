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

/// The leaves of a grid that one rank computed, stored until the rank that writes the grid takes them.
struct OwnLeaves {
    std::size_t all = 0;                ///< leaves in the whole grid
    std::vector<std::uint32_t> numbers; ///< of the own leaves among them, ascending
    StoredLeaves stored;
};

/// Store a domain's own leaves of a grid. @param grid of float or int32; has at least those
[[nodiscard]] OwnLeaves storeOwn(const Domain& domain, const openvdb::GridBase& grid, VdbCompression compression);

/// Bring the leaves of grids that the ranks computed together to the ranks that write them: all of rank r's grid to
/// rank r. Collective. It goes on in chunks, so a writer needs no memory for a whole grid.
/// @param grids  one for each rank that writes, the first ones
/// @param stream takes the leaves of this rank's grid, in the domain's order; null if this rank does not write
void deliver(Exchange& exchange, std::vector<OwnLeaves> grids, LeafStream* stream);

/// A grid whose leaves the ranks computed together, whole, at rank 0; at the others null. Collective.
/// @param grid of float or int32; has this rank's own leaves
[[nodiscard]] openvdb::GridBase::Ptr gathered(Exchange& exchange, const Domain& domain, const openvdb::GridBase& grid);

/// A grid with all leaves of a domain and no values, and otherwise as `grid`: to be written with stored leaves.
/// @param grid of float or int32
[[nodiscard]] openvdb::GridBase::Ptr withoutValues(const Domain& domain, const openvdb::GridBase& grid);

} // namespace vdblic
