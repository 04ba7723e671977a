#pragma once

#include "vdblic/field/domain.h"

#include <cstddef>
#include <cstdint>

namespace vdblic {

/// The texture of a leaf in a step: the mean of the values that hit each voxel, in [0, 1]; a voxel without hits keeps
/// its input, one outside the mask has 0.
///
/// @param hits    Hits words
/// @param input   of the step, fixed-point (kNoiseMax)
/// All have 512 values, x slowest. Thread-safe.
void convolve(const Domain::Mask& mask, const std::int64_t* hits, const std::int32_t* input, float* texture);

/// A leaf of a running mean: 512 values of each, x slowest. Both are null if there is none.
struct MeanLeaf {
    float *mean = nullptr, *weight = nullptr;
};

/// The texture with substeps: the mean over the last steps, in which hits count less the older they are.
///
/// A single substep moves a pathline by a fraction of a voxel or little more: too few voxels are hit for a texture, and
/// too few hits average to it. With weights that fall by (N − 1) / (N + 1) in each of N substeps the mean age of the
/// hits is half a frame, as it is without substeps.
struct RunningMean {
    LeafValues<float> mean;   ///< in [0, 1]
    LeafValues<float> weight; ///< of the hits that `mean` is of

    [[nodiscard]] MeanLeaf of(std::size_t leaf) const { return {mean[leaf], weight[leaf]}; }
};

/// A leaf of the running mean after a step, from the one after the step before. Otherwise as convolve() for one step.
void convolve(const Domain::Mask& mask, const std::int64_t* hits, const std::int32_t* input, int substeps,
              const MeanLeaf& before, const MeanLeaf& after);

/// Values on a domain's own leaves with room for its other local ones. Of a process alone, the values themselves.
[[nodiscard]] LeafValues<float> onLocal(const Domain& domain, const LeafValues<float>& own);

/// The running mean on another domain: a new voxel has its input, without weight.
[[nodiscard]] RunningMean onDomain(const Domain& to, const LeafValues<std::int32_t>& input, const Domain& from,
                                   const RunningMean& mean);

} // namespace vdblic
