#pragma once

#include <cstddef>

namespace vdblic {

/// Threads that parallel work started here may use: what TBB's arena and its limit allow. Thread-safe.
[[nodiscard]] std::size_t threadCount();

} // namespace vdblic
