#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/distributed/partition.h"

#include <openvdb/openvdb.h>

namespace vdblic {

/// The active values of a tree whose leaves lie in a box. Tiles are cut into tiles of a leaf's size.
/// @param box whole leaves
[[nodiscard]] openvdb::Vec3STree::Ptr clippedTree(const openvdb::Vec3STree& tree, const openvdb::CoordBBox& box);

/// A rank's part of a velocity with a rim around it, taken from the ranks that own it. Collective.
/// @param own at least the values in the rank's own box  @param rim [voxels of the velocity], whole leaves
[[nodiscard]] openvdb::Vec3STree::Ptr withHalo(const openvdb::Vec3STree& own, Exchange& exchange,
                                               const Partition& partition, const openvdb::Coord& rim);

} // namespace vdblic
