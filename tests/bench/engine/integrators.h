#pragma once

#include "bench/engine/flow.h"

namespace vdblic::bench {

/// Million RK4 steps a second, one from each voxel's centre in scan order.
[[nodiscard]] double ourStepRate(const Flow& flow);

/// The same by OpenVDB's VelocityIntegrator, which knows one frame.
[[nodiscard]] double openvdbStepRate(const Flow& flow);

} // namespace vdblic::bench
