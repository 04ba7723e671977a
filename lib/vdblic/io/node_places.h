#pragma once

#include <openvdb/Grid.h>

namespace vdblic {

/// Whether each node of a grid lies where its parent has it. OpenVDB takes the places of a root's children, and those
/// of leaves in formats before 222, as a file has them: nodes may overlap then, or lie outside of the tree's box, which
/// every algorithm relies upon.
[[nodiscard]] bool hasNodesInPlace(const openvdb::GridBase& grid);

} // namespace vdblic
