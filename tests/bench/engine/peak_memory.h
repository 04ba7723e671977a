#pragma once

#include <nlohmann/json.hpp>

namespace vdblic::bench {

/// Measure the peak memory of vdblic_advect, the tool of the same build, by size: prints a table. To be called before
/// anything large is allocated, because a child's peak includes the pages it inherits.
nlohmann::json measurePeakMemory();

} // namespace vdblic::bench
