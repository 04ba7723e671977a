#pragma once

#include <nlohmann/json.hpp>

namespace vdblic::bench {

/// Measure how the time grows with life span, size, share of active voxels and threads: prints tables.
nlohmann::json sweepParameters();

} // namespace vdblic::bench
