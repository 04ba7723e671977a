#pragma once

#include <chrono>

namespace vdblic {

/// Wall time in seconds since it was made or last asked. Not thread-safe.
class Stopwatch {
  public:
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
