#pragma once

#include <openvdb/Grid.h>

namespace vdblic {

/// Whether each node's origin is its place in its parent. OpenVDB does not check the origins in a file, those of a
/// root's children and (before format 222) of leaves. Nodes might overlap, or lie outside the tree's box on which every
/// algorithm relies.
[[nodiscard]] bool hasNodesInPlace(const openvdb::GridBase& grid);

} // namespace vdblic
