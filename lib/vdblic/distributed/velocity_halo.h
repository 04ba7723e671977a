#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/distributed/partition.h"

#include <openvdb/openvdb.h>

#include <vector>

namespace vdblic {

/// Move the active values in a box out of a velocity. Tiles are cut into leaf-sized tiles.
/// @param tree loses those leaves  @param box whole leaves
[[nodiscard]] openvdb::Vec3STree::Ptr takenOut(openvdb::Vec3STree& tree, const VoxelBox<Space::kVelocity>& box);

/// Add other ranks' values to a rank's part of a velocity. Collective.
/// @param tree   contains the values in the rank's own box
/// @param wanted the box in which each rank needs values, whole leaves
/// @param period of the velocity: values whose images lie in the box are added too
void addParts(openvdb::Vec3STree& tree, Exchange& exchange, const Partition& partition,
              const std::vector<VoxelBox<Space::kVelocity>>& wanted, const Period& period);

/// The active voxels of a velocity whose parts are spread over the ranks in any way. Collective.
/// @throws InputError if two ranks have the same voxel
[[nodiscard]] openvdb::MaskTree::Ptr joinedTopology(const openvdb::Vec3STree& part, Exchange& exchange);

/// Add the values of the rank's own box to its part of such a velocity. Collective.
void gatherParts(openvdb::Vec3STree& part, Exchange& exchange, const Partition& partition);

} // namespace vdblic
