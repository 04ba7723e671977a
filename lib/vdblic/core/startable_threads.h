#pragma once

#include <cstddef>

namespace vdblic {

/// The number of further threads that the system would start now, within the limits on memory (a stack has 8 MiB) and
/// on the user's or the container's processes. @param most to try
[[nodiscard]] std::size_t startableThreads(std::size_t most);

} // namespace vdblic
