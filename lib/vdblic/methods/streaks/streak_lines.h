#pragma once

#include "vdblic/lines/lines.h"
#include "vdblic/methods/streaks/streak.h"
#include "vdblic/methods/streaks/streak_shape.h"

#include <openvdb/openvdb.h>

#include <vector>

namespace vdblic {

/// The tails of streaks at a time as polylines, so fine that a polyline is never farther from the pathline's point of
/// the same time than a quarter of the streak's radius. Parts that are invisible or outside the domain are left out; a
/// tail cut by them makes several lines.
///
/// @param domain    voxels of the velocity
/// @param time      of the heads [frames since the run began]
/// @param transform of the velocity, for the radii
/// Computed in parallel; the result does not depend on the number of threads.
[[nodiscard]] Lines streakLines(const std::vector<Streak>& streaks, const StreakShape& shape, const Domain& domain,
                                double time, const openvdb::math::Transform& transform);

} // namespace vdblic
