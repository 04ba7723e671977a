#pragma once

#include "vdblic/field/domain.h"

#include <cstdint>

namespace vdblic {

/// The texture of a step: mean of the values that hit each voxel, in [0, 1]; a voxel without hits keeps its input.
///
/// @param accumulator Hits words of Scatter::step()
/// @param input       of the step, fixed-point (kNoiseMax), on the own leaves
/// @return on the own leaves, with room for the other local ones
/// Computed in parallel; the result does not depend on the number of threads.
[[nodiscard]] LeafValues<float> convolve(const Domain& domain, const LeafValues<std::int64_t>& accumulator,
                                         const LeafValues<std::int32_t>& input);

/// The texture with substeps: the mean over the last steps, in which hits count less the older they are.
///
/// A single substep moves a pathline by a fraction of a voxel or little more: too few voxels are hit for a texture, and
/// too few hits average to it. With weights that fall by (N − 1) / (N + 1) in each of N substeps the mean age of the
/// hits is half a frame, as it is without substeps.
struct RunningMean {
    LeafValues<float> mean;   ///< in [0, 1]
    LeafValues<float> weight; ///< of the hits that `mean` is of
};

/// The running mean after a step. @param before the mean after the step before, on the same domain; null if none
/// Otherwise as convolve(), whose texture it is for one substep.
[[nodiscard]] RunningMean convolve(const Domain& domain, const LeafValues<std::int64_t>& accumulator,
                                   const LeafValues<std::int32_t>& input, const RunningMean* before, int substeps);

/// Values on a domain's own leaves with room for its other local ones. Of a process alone, the values themselves.
[[nodiscard]] LeafValues<float> onLocal(const Domain& domain, const LeafValues<float>& own);

/// The running mean on another domain: a new voxel has its input, without weight.
[[nodiscard]] RunningMean onDomain(const Domain& to, const LeafValues<std::int32_t>& input, const Domain& from,
                                   const RunningMean& mean);

} // namespace vdblic
