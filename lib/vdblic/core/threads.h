#pragma once

#include <cstddef>

namespace vdblic {

/// The threads that parallel work started here may use, by TBB's arena and its limit. Thread-safe.
[[nodiscard]] std::size_t threadCount();

} // namespace vdblic
