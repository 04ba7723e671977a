#pragma once

#include "vdblic/flow/velocity_frame.h"

namespace vdblic {

/// The flow between two frames of a sequence, as linear interpolation in time has it.
///
/// A voxel that has a velocity in only one of the frames keeps that velocity. Domain, file and carried grids are those
/// of the frame before. Computed in parallel; the result does not depend on the number of threads.
/// @param fraction of the interval, 0 to 1
[[nodiscard]] VelocityFrame frameBetween(const VelocityFrame& before, const VelocityFrame& after, double fraction);

} // namespace vdblic
