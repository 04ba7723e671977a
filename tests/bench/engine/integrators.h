#pragma once

#include "bench/engine/flow.h"

#include <nlohmann/json.hpp>

namespace vdblic::bench {

/// Measure RK4 steps a second, one from each voxel's centre in scan order, with ours, OpenVDB's, NanoVDB's and VTK's
/// interpolation, as far as they are installed: prints a table.
nlohmann::json compareIntegrators(const Flow& flow);

} // namespace vdblic::bench
