#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/distributed/partition.h"

#include <openvdb/openvdb.h>

#include <vector>

namespace vdblic {

/// The active values of a tree whose leaves lie in a box. Tiles are cut into tiles of a leaf's size.
/// @param tree loses those leaves  @param box whole leaves
[[nodiscard]] openvdb::Vec3STree::Ptr takenOut(openvdb::Vec3STree& tree, const openvdb::CoordBBox& box);

/// Add a rim to a rank's part of a velocity, from the ranks that own it. Collective.
/// @param tree has at least the values in the rank's own box  @param rims of all ranks [voxels of the velocity], whole
///             leaves
void addHalo(openvdb::Vec3STree& tree, Exchange& exchange, const Partition& partition,
             const std::vector<openvdb::Coord>& rims);

} // namespace vdblic
