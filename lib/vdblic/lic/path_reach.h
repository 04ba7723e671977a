#pragma once

#include "vdblic/field/leaf_voxel.h"

#include <algorithm>
#include <cmath>

namespace vdblic {

/// The farthest that a path of a step leads from its start, along an axis [voxels]. @param slope the largest
/// displacement in a step: the Hermite curve swings beyond its ends by at most 4/27 of the slope at each.
[[nodiscard]] constexpr float longestPath(float slope)
{
    constexpr float kSwing = 1 + 2 * 4.0f / 27, kRounding = 1; // voxels
    return kSwing * slope + kRounding;
}

/// How many leaves away a distance may lead, along an axis. @param voxels of the distance
[[nodiscard]] inline int leavesReached(float voxels)
{
    constexpr float kFarAway = 1e6f;
    return int(std::ceil(std::min(voxels, kFarAway) / float(LeafVoxel::kDim)));
}

} // namespace vdblic
