#pragma once

#include "vdblic/field/domain.h"

#include <cstddef>
#include <limits>

namespace vdblic {

/// The range to which values are clamped.
struct ValueRange {
    float least = -std::numeric_limits<float>::infinity(), most = std::numeric_limits<float>::infinity();
};

/// High-pass filter: c + strength · (c − mean of the 26 neighbours inside the domain), for every voxel; c
/// itself without neighbours.
///
/// @param texture 0 wherever the domain has no voxel
/// @param range   of the results
/// Computed in parallel; the result does not depend on the number of threads. Shen & Kao 1998, section 3.3.
[[nodiscard]] LeafValues<float> sharpened(const Domain& domain, const LeafValues<float>& texture, float strength,
                                          const ValueRange& range = {});

/// The same for one leaf; 0 outside the domain. @param result 512 values, x slowest. Thread-safe.
void sharpen(const Domain& domain, const LeafValues<float>& texture, std::size_t leaf, float strength,
             const ValueRange& range, float* result);

} // namespace vdblic
