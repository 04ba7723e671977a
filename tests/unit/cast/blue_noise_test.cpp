#include "vdblic/cast/blue_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <set>
#include <vector>

namespace vdblic {
namespace {

TEST(BlueNoiseTile, HoldsEveryRankOnce)
{
    const BlueNoise& noise = blueNoise();
    EXPECT_EQ(std::set<int>(noise.ranks.begin(), noise.ranks.end()).size(), std::size_t(BlueNoise::kCount));
    EXPECT_EQ(noise.rank(3, 5), noise.rank(3 + 32, 5 + 64));
}

TEST(BlueNoiseTile, HasNoLowFrequencyAndNoFrequencyThatStandsOut)
{
    constexpr int n = BlueNoise::kDim;
    // Power by frequency; that of white noise with the same values is 1 on average.
    std::vector<std::complex<double>> rows(std::size_t(n * n));
    const auto wave = [](int k, int x) { return std::polar(1.0, -2 * std::numbers::pi * k * x / n); };
    for (int y = 0; y < n; ++y) {
        for (int k = 0; k < n; ++k) {
            for (int x = 0; x < n; ++x)
                rows[std::size_t(y * n + k)] += (blueNoise().rank(x, y) + 0.5) / BlueNoise::kCount * wave(k, x);
        }
    }
    double low = 0, most = 0;
    int lows = 0;
    for (int k = 0; k < n; ++k) {
        for (int m = 0; m < n; ++m) {
            std::complex<double> sum = 0;
            for (int y = 0; y < n; ++y)
                sum += rows[std::size_t(y * n + k)] * wave(m, y);
            const double power = std::norm(sum) * 12 / (n * n);
            const double frequency = std::hypot(std::min(k, n - k), std::min(m, n - m));
            if (frequency == 0) continue;
            most = std::max(most, power);
            if (frequency > n / 6.0) continue;
            low += power;
            ++lows;
        }
    }
    EXPECT_LT(low / lows, 0.05);
    EXPECT_LT(most, 20); // a lattice has its whole power, thousands, in a few frequencies
}

} // namespace
} // namespace vdblic
