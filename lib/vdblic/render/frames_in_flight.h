#pragma once

#include <cstddef>

namespace vdblic {

/// How many frames to work on side by side: as many as there are threads, while half of the memory that is free now
/// holds them; at least one. With fewer frames than threads the tiles of each frame are shared out.
/// @param frameBytes that one frame takes
[[nodiscard]] std::size_t framesInFlight(double frameBytes);

} // namespace vdblic
