#pragma once

#include <cstddef>

namespace vdblic {

/// The threads that parallel work started here may use, by TBB's arena and its limit. Thread-safe.
[[nodiscard]] std::size_t threadCount();

/// The number of further threads that the system would start now, within the limits on memory (a stack has 8 MiB) and
/// on the user's or the container's processes. @param most to try
[[nodiscard]] std::size_t startableThreads(std::size_t most);

} // namespace vdblic
