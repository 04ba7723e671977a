#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/methods/auflic/convolve.h"
#include "vdblic/methods/auflic/particle_bins.h"
#include "vdblic/methods/state_grids.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace vdblic {

/// \file
/// The state between two steps as grids that other programs can open; a round trip preserves every bit.
///
/// `noise`: the noise-jittered texture that gives seeds their values, float, multiples of 1/65536 in [0, 1). With
/// substeps also `mean` and `weight`, the RunningMean. `particles`: points with the attributes `slope` (velocity there,
/// voxels per step), `id` (step of release << 43 | number of the release voxel), `alive` (its Hits) and, for methods
/// that use them, `words`. A point's position is stored relative to the centre of its voxel, which preserves all bits.
///
/// Each grid holds a part of the leaves, so that no second copy of the whole state is in memory.

/// The grid `noise`. @param input of a step, fixed-point (kNoiseMax)
[[nodiscard]] openvdb::GridBase::Ptr inputGrid(const Domain& domain, Domain::Leaves leaves,
                                               const LeafValues<std::int32_t>& input);

/// The grids `mean` and `weight` of a running mean.
[[nodiscard]] openvdb::GridPtrVec meanGrids(const Domain& domain, Domain::Leaves leaves, const RunningMean& mean);

/// The grid `particles`. Equal particles give an equal grid, whichever bins hold them.
/// @param domain its leaves are the bins' tiles
[[nodiscard]] openvdb::GridBase::Ptr particleGrid(const Domain& domain, Domain::Leaves leaves,
                                                  const std::vector<ParticleBins>& bins);

/// A run's state between two steps, on a domain's own leaves.
struct FlowState {
    LeafValues<std::int32_t> input;
    std::optional<RunningMean> mean; ///< with substeps
    ParticleBins particles;
};

/// Reads a state from its files, one after the other. Not thread-safe.
class FlowStateReader {
  public:
    /// @param domain      must outlive this
    /// @param words  per particle beside its Hits
    FlowStateReader(const Domain& domain, std::size_t words, bool hasMean);

    /// Read the own leaves in a file.
    /// @throws InputError, without the file's name, if a grid is missing or does not fit the domain
    void add(const VdbFile& file);

    /// @throws InputError if an own leaf was in no file
    [[nodiscard]] FlowState finish();

  private:
    const Domain& mDomain;
    StateGridReader mGrids;
    FlowState mState;
};

} // namespace vdblic
