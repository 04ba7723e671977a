#pragma once

#include <chrono>
#include <ctime>

namespace vdblic::bench {

/// Processor time of this process, of all its threads [s].
inline double cpuTime()
{
    return double(std::clock()) / CLOCKS_PER_SEC;
}

inline double wallTime()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

} // namespace vdblic::bench
