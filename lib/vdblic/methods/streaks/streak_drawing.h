#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/methods/streaks/streak.h"
#include "vdblic/methods/streaks/streak_shape.h"

#include <openvdb/openvdb.h>

#include <optional>
#include <vector>

namespace vdblic {

/// Streaks as voxels of the texture.
struct DrawnStreaks {
    openvdb::FloatTree::Ptr texture;  ///< in (0, 1], active only on streaks
    openvdb::FloatTree::Ptr source{}; ///< number of the source of each voxel's brightest streak
};

/// Draw the recent part of each streak's pathline as a tube, brightest and thickest at its head.
///
/// The value falls linearly to 0 from head to tail, and across the streak as (1 − d²)², where d is 1 at the tube's rim:
/// active voxels are visible. Ahead of the head it falls twice as steeply. Where streaks meet, the brighter one is
/// drawn, so their order does not matter. Tubes are round in texture voxels, or ellipsoidal where the shape's radius
/// differs from axis to axis.
///
/// @param domain   voxels of the velocity; drawn voxels lie in its active voxels and own leaves
/// @param time     of the heads [frames since the run began]
/// @param hasSources whether to make `source`
/// Computed in parallel; the result does not depend on the number of threads.
[[nodiscard]] DrawnStreaks drawStreaks(const std::vector<Streak>& streaks, const StreakShape& shape,
                                       const Domain& domain, double time, bool hasSources);

} // namespace vdblic
