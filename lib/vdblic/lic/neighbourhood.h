#pragma once

#include "vdblic/field/domain.h"

#include <array>

namespace vdblic {

/// For each voxel of a leaf, x slowest: sums over the voxels of the domain among it and its 26 neighbours.
struct NeighbourSums {
    std::array<float, Domain::kLeafVoxels> value;  ///< of the weighted values
    std::array<float, Domain::kLeafVoxels> weight; ///< of the weights
};

/// @param values 0 wherever the domain has no voxel
/// @param centre weight of a voxel itself along each axis, its two neighbours having 1; with 2 the weights are binomial
[[nodiscard]] NeighbourSums sumNeighbours(const Domain& domain, const LeafValues<float>& values, std::size_t leaf,
                                          float centre);

} // namespace vdblic
