#pragma once

#include "vdblic/field/domain.h"

#include <cstdint>

namespace vdblic {

/// The texture of a step: mean of the values that hit each voxel, in [0, 1]; a voxel without hits keeps its input.
///
/// @param accumulator Hits words of Scatter::step()
/// @param input       Input words of the step
/// Computed in parallel; the result does not depend on the number of threads.
[[nodiscard]] LeafValues<float> convolve(const Domain& domain, const LeafValues<std::int64_t>& accumulator,
                                         const LeafValues<std::int32_t>& input);

} // namespace vdblic
