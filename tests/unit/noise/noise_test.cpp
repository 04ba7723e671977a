#include "vdblic/noise/noise.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace vdblic {
namespace {

constexpr int kSide = 64;

/// Pearson's statistic of the 65536 values' top six bits against equal counts.
double chiSquare(const std::vector<int>& values)
{
    std::array<double, 64> counts{};
    for (const int value : values)
        ++counts[std::size_t(value >> 10)];
    const double expected = double(values.size()) / double(counts.size());
    double sum = 0;
    for (const double count : counts)
        sum += (count - expected) * (count - expected) / expected;
    return sum;
}

/// Correlation of the noise with itself (or another seed's) at an offset.
double correlation(openvdb::Coord offset, std::uint32_t seed, std::uint32_t other)
{
    double sumA = 0, sumB = 0, sumAA = 0, sumBB = 0, sumAB = 0;
    for (int x = -kSide / 2; x < kSide / 2; ++x) {
        for (int y = -kSide / 2; y < kSide / 2; ++y) {
            for (int z = -kSide / 2; z < kSide / 2; ++z) {
                const double a = noiseValue(x, y, z, seed);
                const double b = noiseValue(x + offset.x(), y + offset.y(), z + offset.z(), other);
                sumA += a, sumB += b, sumAA += a * a, sumBB += b * b, sumAB += a * b;
            }
        }
    }
    const double n = double(kSide) * kSide * kSide;
    return (sumAB - sumA * sumB / n) / std::sqrt((sumAA - sumA * sumA / n) * (sumBB - sumB * sumB / n));
}

TEST(Noise, GoldenValues)
{
    // Made by an independent implementation in Python's unbounded integers.
    EXPECT_EQ(noiseValue(0, 0, 0, 0), 18465);
    EXPECT_EQ(noiseValue(1, 2, 3, 7), 26103);
    EXPECT_EQ(noiseValue(-1, -2, -3, 7), 17659);
    EXPECT_EQ(noiseValue(100000, -131072, 131071, 4294967295u), 25928);
}

TEST(Noise, RowsHoldTheValuesOfTheirVoxels)
{
    for (const int first : {0, 8, -8, -4, 131064, -131072}) {
        const Int8 row = noiseRow(noiseColumn(first, -3, 7), first);
        for (int i = 0; i < 8; ++i)
            EXPECT_EQ(row[i], noiseValue(first, -3, first + i, 7)) << first << ", " << i;
    }
}

TEST(Noise, IsUniform)
{
    for (const std::uint32_t seed : {0u, 1u, 12345u}) {
        std::vector<int> values;
        constexpr int kCount = kSide * kSide * kSide;
        values.reserve(kCount);
        for (int i = 0; i < kCount; ++i)
            values.push_back(noiseValue(i / (kSide * kSide) - 32, i / kSide % kSide - 32, i % kSide - 32, seed));
        // 63 degrees of freedom: 103.4 is exceeded once in a thousand, 30 is undercut once in ten thousand.
        EXPECT_LT(chiSquare(values), 103.4) << "seed " << seed;
        EXPECT_GT(chiSquare(values), 30) << "seed " << seed;
    }
}

TEST(Noise, NeighboursAreIndependent)
{
    // The deviation of the correlation of independent values is 1/√262144 ≈ 0.002.
    constexpr double kBound = 0.008;
    EXPECT_NEAR(correlation({1, 0, 0}, 1, 1), 0, kBound);
    EXPECT_NEAR(correlation({0, 1, 0}, 1, 1), 0, kBound);
    EXPECT_NEAR(correlation({0, 0, 1}, 1, 1), 0, kBound);
    EXPECT_NEAR(correlation({1, -1, 1}, 1, 1), 0, kBound);
    EXPECT_NEAR(correlation({0, 0, 0}, 1, 1), 1, 1e-12);
}

TEST(Noise, SeedsAreIndependent)
{
    EXPECT_NEAR(correlation({0, 0, 0}, 1, 2), 0, 0.008);
    EXPECT_NEAR(correlation({0, 0, 1}, 1, 2), 0, 0.008);
    EXPECT_NEAR(correlation({0, 0, 0}, 0, 4294967295u), 0, 0.008);
}

TEST(Noise, GridHoldsTheFunctionOnItsActiveVoxelsOnly)
{
    auto dense = std::make_shared<openvdb::MaskTree>();
    dense->fill(openvdb::CoordBBox(openvdb::Coord(-20), openvdb::Coord(20)), true);
    auto sparse = std::make_shared<openvdb::MaskTree>();
    for (int i = 0; i < 20; ++i)
        sparse->setValueOn(openvdb::Coord(-20 + 2 * i, 3 * i % 17, 20 - i));

    const auto transform = openvdb::math::Transform::createLinearTransform(0.5);
    const auto denseNoise = makeNoise(Domain(dense), *transform, 5);
    const auto sparseNoise = makeNoise(Domain(sparse), *transform, 5);
    EXPECT_EQ(denseNoise->getName(), "noise");
    EXPECT_EQ(denseNoise->transform(), *transform);
    EXPECT_EQ(denseNoise->metaValue<std::int64_t>("seed"), 5);
    EXPECT_EQ(denseNoise->activeVoxelCount(), 41u * 41u * 41u);
    ASSERT_EQ(sparseNoise->activeVoxelCount(), 20u);
    for (auto it = denseNoise->cbeginValueOn(); it; ++it) {
        const openvdb::Coord at = it.getCoord();
        ASSERT_FLOAT_EQ(*it, float(noiseValue(at.x(), at.y(), at.z(), 5)) / 65535) << at;
    }
    for (auto it = sparseNoise->cbeginValueOn(); it; ++it) {
        EXPECT_EQ(*it, denseNoise->tree().getValue(it.getCoord()));
    }
    for (auto it = sparseNoise->cbeginValueOff(); it; ++it)
        ASSERT_EQ(*it, 0);
}

} // namespace
} // namespace vdblic
