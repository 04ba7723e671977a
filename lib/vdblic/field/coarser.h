#pragma once

#include <openvdb/openvdb.h>

namespace vdblic {

/// A grid with half the voxels along each axis: means of the active ones among eight.
///
/// Voxel c covers the voxels 2c and 2c + 1 of the finer grid along each axis: its centre is 2c + ½ there. It is active
/// if one of them is. Staggered components are means of the four finer faces in a coarser one. Name and metadata stay.
/// Computed in parallel, leaf by leaf.
///
/// @param grid        of floats, doubles or vectors of them
/// @param countsEmpty inactive voxels count as 0 (streaks), which preserves optical depth
/// @return a grid of floats or vectors of floats; null for grids of other types
/// @throws InputError if tiles expand to more voxels than the memory holds
[[nodiscard]] openvdb::GridBase::Ptr coarser(const openvdb::GridBase& grid, bool countsEmpty);

} // namespace vdblic
