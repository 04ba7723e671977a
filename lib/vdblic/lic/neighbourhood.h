#pragma once

#include "vdblic/field/domain.h"

#include <array>

namespace vdblic {

/// Values and validity (1 or 0) of a leaf's voxels and all their neighbours, x slowest.
struct Neighbourhood {
    static constexpr int kDim = Domain::Leaf::DIM + 2;
    using Numbers = std::array<float, kDim * kDim * kDim>;

    Numbers value, valid;

    /// Where a voxel of the leaf stands, from its place in the leaf; −1 to 8 along each axis.
    static constexpr std::size_t index(int x, int y, int z)
    {
        return std::size_t(((x + 1) * kDim + y + 1) * kDim + z + 1);
    }
};

/// The neighbourhood of a leaf; values are 0 where they are not valid.
[[nodiscard]] Neighbourhood gatherNeighbourhood(const Domain& domain, const LeafValues<float>& values,
                                                const openvdb::Coord& origin);

/// Replace each number by the sum over its 3³ neighbourhood, one axis after the other.
/// @param centre weight of the number itself along each axis, its two neighbours having 1; with 2 the weights are
/// binomial
void sumNeighbours(Neighbourhood::Numbers& numbers, float centre = 1);

} // namespace vdblic
