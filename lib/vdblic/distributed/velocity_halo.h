#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/distributed/partition.h"

#include <openvdb/openvdb.h>

#include <vector>

namespace vdblic {

/// The active values of a velocity whose leaves lie in a box. Tiles are cut into tiles of a leaf's size.
/// @param tree loses those leaves  @param box whole leaves
[[nodiscard]] openvdb::Vec3STree::Ptr takenOut(openvdb::Vec3STree& tree, const VoxelBox<Space::kVelocity>& box);

/// Add to a rank's part of a velocity what other ranks own. Collective.
/// @param tree   has at least the values in the rank's own box
/// @param wanted the box that each rank is to have the values in, whole leaves
void addParts(openvdb::Vec3STree& tree, Exchange& exchange, const Partition& partition,
              const std::vector<VoxelBox<Space::kVelocity>>& wanted);

/// The active voxels of a velocity whose parts lie among the ranks in any way. Collective.
/// @throws InputError if two ranks have the same voxel
[[nodiscard]] openvdb::MaskTree::Ptr joinedTopology(const openvdb::Vec3STree& part, Exchange& exchange);

/// Add to a rank's part of such a velocity what lies in the rank's own box. Collective.
void gatherParts(openvdb::Vec3STree& part, Exchange& exchange, const Partition& partition);

} // namespace vdblic
