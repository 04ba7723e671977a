#pragma once

#include "vdblic/methods/streaks/streak.h"
#include "vdblic/methods/streaks/streak_shape.h"

#include <openvdb/openvdb.h>

#include <vector>

namespace vdblic {

struct VdbFile;

/// \file
/// Streaks between two steps as a grid that other programs can open; a round trip preserves every bit.
///
/// `streaks`: a point for each node of each path. Attributes of a node: `node` (its position, exactly, in index space
/// of the velocity), `slope` (voxels a frame), `time` (frames since the run began); of its streak: `id` (its name),
/// `born`, `retired`, `kind` (1 slid in, 2 stopped, and 4 times the number of its source). The shape is metadata of the
/// grid.

/// The grid `streaks`.
[[nodiscard]] openvdb::GridBase::Ptr streakGrid(const std::vector<Streak>& streaks, const StreakShape& shape);

struct StreakState {
    std::vector<Streak> streaks;
    StreakShape shape;
};
/// @throws InputError, without the file's name, if the grid is missing or holds no state
[[nodiscard]] StreakState readStreaks(const VdbFile& file);

} // namespace vdblic
