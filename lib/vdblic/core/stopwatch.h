#pragma once

#include <chrono>

namespace vdblic {

/// Wall time between laps. Not thread-safe.
class Stopwatch {
  public:
    /// Seconds since construction or the last lap.
    double lap()
    {
        const auto now = std::chrono::steady_clock::now();
        const std::chrono::duration<double> passed = now - mLast;
        mLast = now;
        return passed.count();
    }

  private:
    std::chrono::steady_clock::time_point mLast = std::chrono::steady_clock::now();
};

} // namespace vdblic
