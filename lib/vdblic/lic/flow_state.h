#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/lic/convolve.h"
#include "vdblic/lic/particle_bins.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

struct VdbFile;

/// \file
/// The state between two steps as grids that other programs can open; a round trip preserves every bit.
///
/// `noise`: the noise-jittered texture that seeds take their values from, float, multiples of 1/65536 in [0, 1). With
/// substeps also `mean` and `weight`, the RunningMean. `particles`: points with the attributes `slope` (velocity there,
/// voxels per step), `id` (step of release << 43 | number of the release voxel) and `generations` (Generation words, by
/// release frame modulo the life span; for UFLIC a single one). A point's position is stored relative to the centre of
/// its voxel, so no bit of it is lost.

/// The grid `noise`. @param input of a step, fixed-point (kNoiseMax)
[[nodiscard]] openvdb::GridBase::Ptr inputGrid(const Domain& domain, const LeafValues<std::int32_t>& input);

/// The inverse of inputGrid(), on the domain's own leaves.
/// @param files of all ranks that wrote the state, or of those that have the own leaves
/// @throws InputError, without the file's name, if a grid is missing or its voxels are not the domain's
[[nodiscard]] LeafValues<std::int32_t> readInput(const Domain& domain, const std::vector<VdbFile>& files);

/// The grids `mean` and `weight` of a running mean; they share its values.
[[nodiscard]] openvdb::GridPtrVec meanGrids(const RunningMean& mean);

/// The inverse of meanGrids(). @throws InputError as readInput()
[[nodiscard]] RunningMean readMean(const Domain& domain, const std::vector<VdbFile>& files);

/// The grid `particles`. Equal particles give an equal grid, whichever bins hold them.
/// @param domain whose leaves are the bins' tiles
[[nodiscard]] openvdb::GridBase::Ptr particleGrid(const Domain& domain, const std::vector<ParticleBins>& bins);

/// The inverse of particleGrid(). @param generations words that each particle carries; 0 for UFLIC
/// @throws InputError, without the file's name, if the grid is missing or does not fit the domain
[[nodiscard]] ParticleBins readParticles(const Domain& domain, const std::vector<VdbFile>& files,
                                         std::size_t generations);

} // namespace vdblic
