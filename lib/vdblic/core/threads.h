#pragma once

#include <cstddef>

namespace vdblic {

/// The threads that parallel work started here may use, by TBB's arena and its limit. Thread-safe.
[[nodiscard]] std::size_t threadCount();

/// The number of further threads that can start now, within the limits on memory (a stack has 8 MiB) and on the user's
/// or container's processes. @param most largest number to try
[[nodiscard]] std::size_t startableThreads(std::size_t most);

} // namespace vdblic
