#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace vdblic {

/// Sums for Pearson's correlation, about the middle of a texture's range to limit cancellation.
class Correlation {
  public:
    void add(float a, float b)
    {
        const double x = double(a) - 0.5, y = double(b) - 0.5;
        mSums[0] += x;
        mSums[1] += y;
        mSums[2] += x * x;
        mSums[3] += y * y;
        mSums[4] += x * y;
        ++mCount;
    }
    void add(const Correlation& other)
    {
        for (std::size_t i = 0; i < mSums.size(); ++i)
            mSums[i] += other.mSums[i];
        mCount += other.mCount;
    }
    [[nodiscard]] std::size_t count() const { return mCount; }
    /// Not-a-number if either texture is constant or no pair was added.
    [[nodiscard]] double value() const
    {
        const double n = double(mCount), x = mSums[0] / n, y = mSums[1] / n;
        const double xx = mSums[2] / n - x * x, yy = mSums[3] / n - y * y;
        constexpr double kLeastVariance = 1e-12; // below: rounding of a constant
        if (!(xx > kLeastVariance && yy > kLeastVariance)) return std::numeric_limits<double>::quiet_NaN();
        return (mSums[4] / n - x * y) / std::sqrt(xx * yy);
    }

  private:
    std::array<double, 5> mSums{};
    std::size_t mCount = 0;
};

} // namespace vdblic
