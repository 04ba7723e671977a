#pragma once

#include <glm/vec3.hpp>

#include <vector>

namespace vdblic {

class ExtinctionGrid;

/// The optical depths between the centres of a grid's cells and a light far away, by cell. They are swept away from the
/// light, slab by slab, interpolated between the cells of the slab before.
/// @param extinctions  of the cells [1/voxel]
/// @param towardsLight index space, any length but 0
/// @param reach        distance after which an e-th of a depth is left [voxels]
/// @param countsItself whether the near half of the cell itself counts
[[nodiscard]] std::vector<float> opticalDepths(const ExtinctionGrid& grid, const std::vector<float>& extinctions,
                                               const glm::dvec3& towardsLight, double reach, bool countsItself);

} // namespace vdblic
