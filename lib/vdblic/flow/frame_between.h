#pragma once

#include "vdblic/flow/velocity_frame.h"

namespace vdblic {

/// The flow between two frames of a sequence, interpolated linearly in time.
///
/// A voxel with a velocity in only one frame keeps it. Domain, file and carried grids are the first frame's. Computed
/// in parallel; the result does not depend on the number of threads.
/// @param fraction of the interval, 0 to 1
[[nodiscard]] VelocityFrame frameBetween(const VelocityFrame& before, const VelocityFrame& after, double fraction);

} // namespace vdblic
