#pragma once

#include "vdblic/field/leaf_voxel.h"

#include <algorithm>
#include <cmath>

namespace vdblic {

/// The farthest distance of a step's path from its start, along an axis [voxels]. @param slope the largest displacement
/// in a step: the Hermite curve overshoots each end by at most 4/27 of its slope.
[[nodiscard]] constexpr float longestPath(float slope)
{
    constexpr float kSwing = 1 + 2 * 4.0f / 27, kRounding = 1; // voxels
    return kSwing * slope + kRounding;
}

/// The number of leaves that a distance can cross, along an axis. @param voxels the distance
[[nodiscard]] inline int leavesReached(float voxels)
{
    constexpr float kFarAway = 1e6f;
    return int(std::ceil(std::min(voxels, kFarAway) / float(LeafVoxel::kDim)));
}

} // namespace vdblic
