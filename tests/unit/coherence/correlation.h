#pragma once

#include <cmath>

namespace vdblic::test {

/// Pearson correlation.
class Correlation {
  public:
    void add(double a, double b)
    {
        ++mCount;
        mA += a;
        mB += b;
        mAA += a * a;
        mBB += b * b;
        mAB += a * b;
    }
    [[nodiscard]] double value() const
    {
        const double ab = mAB / mCount - mA / mCount * mB / mCount;
        return ab / std::sqrt((mAA / mCount - mA / mCount * mA / mCount) * (mBB / mCount - mB / mCount * mB / mCount));
    }
    [[nodiscard]] double mean() const { return mA / mCount; }
    [[nodiscard]] double deviation() const { return std::sqrt(mAA / mCount - mA / mCount * mA / mCount); }

  private:
    double mCount = 0, mA = 0, mB = 0, mAA = 0, mBB = 0, mAB = 0;
};

} // namespace vdblic::test
