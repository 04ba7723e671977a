#pragma once

#include <cstddef>

namespace vdblic {

/// How many more threads the system would start now: by the limits on memory (a stack has 8 MiB) and on the user's or
/// the container's processes. @param most to try
[[nodiscard]] std::size_t startableThreads(std::size_t most);

} // namespace vdblic
