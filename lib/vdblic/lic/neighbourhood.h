#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/leaf_voxel.h"

#include <array>
#include <cstddef>

namespace vdblic {

/// For each voxel of a leaf, x slowest: sums over the voxel and its 26 neighbours inside the domain.
struct NeighbourSums {
    std::array<float, LeafVoxel::kCount> value;  ///< of the weighted values
    std::array<float, LeafVoxel::kCount> weight; ///< of the weights
};

/// @param values 0 wherever the domain has no voxel
/// @param centre weight of a voxel itself along each axis; its two neighbours have 1. With 2 the weights are binomial
/// Thread-safe.
[[nodiscard]] NeighbourSums sumNeighbours(const Domain& domain, const LeafValues<float>& values, std::size_t leaf,
                                          float centre);

} // namespace vdblic
