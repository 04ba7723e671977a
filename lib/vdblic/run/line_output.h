#pragma once

#include "vdblic/core/exchange.h"

#include <openvdb/openvdb.h>

#include <vector>

namespace vdblic {

struct TextureFrame;

/// The streaks of a frame as points (lineGrid()), with the given scalars and those that the frame carries. Collective
/// if several ranks share the frame: the owner of a point's voxel interpolates, the writer makes the grid.
/// @param scalars with values on this rank's local leaves of the velocity
/// @param writer  rank that gets the grid; carried scalars are there
/// @param made    loses its lines
/// @return null at the other ranks
[[nodiscard]] openvdb::GridBase::Ptr lineOutput(Exchange& exchange, int writer,
                                                std::vector<openvdb::FloatGrid::Ptr> scalars, TextureFrame& made);

} // namespace vdblic
