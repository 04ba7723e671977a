#include "vdblic/field/vector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>

namespace vdblic {
namespace {

const float kNumbers[] = {0,
                          -0.0f,
                          0.25f,
                          -0.25f,
                          0.5f,
                          -0.5f,
                          0.999999f,
                          -0.999999f,
                          1,
                          -1,
                          1.5f,
                          -1.5f,
                          7.9999f,
                          8,
                          -7.9999f,
                          -8,
                          -8.0001f,
                          12345.6f,
                          -12345.6f,
                          8388607.5f,
                          -8388607.5f,
                          2e9f,
                          -2e9f,
                          std::numeric_limits<float>::denorm_min(),
                          -std::numeric_limits<float>::denorm_min()};

TEST(FloorToInt, IsTheLargestIntegerNotAbove)
{
    for (const float x : kNumbers) {
        const Int4 four = floorToInt(Float4{x, 0.5f, -x, -0.5f});
        EXPECT_EQ(four[0], std::int32_t(std::floor(x))) << x;
        EXPECT_EQ(four[1], 0);
        EXPECT_EQ(four[2], std::int32_t(std::floor(-x))) << x;
        EXPECT_EQ(four[3], -1);
        const Int8 eight = floorToInt(Float8{x, 1, 2, 3, -1, -2, -3, -x});
        EXPECT_EQ(eight[0], std::int32_t(std::floor(x))) << x;
        EXPECT_EQ(eight[7], std::int32_t(std::floor(-x))) << x;
        for (int lane = 1; lane < 4; ++lane)
            EXPECT_EQ(eight[lane], lane);
        for (int lane = 4; lane < 7; ++lane)
            EXPECT_EQ(eight[lane], 3 - lane);
    }
}

TEST(FloorToInt, IsAnEndOfTheRangeForNumbersThatNoIntHolds)
{
    constexpr std::int32_t kLowest = std::numeric_limits<std::int32_t>::min();
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const volatile float numbers[] = {0x1p31f,     1e30f,  kInfinity,  std::numeric_limits<float>::quiet_NaN(),
                                      -0x1.01p31f, -1e30f, -kInfinity, -0x1p31f};
    Float8 x;
    for (int lane = 0; lane < 8; ++lane)
        x[lane] = numbers[lane];
    const Int8 eight = floorToInt(x);
    for (int lane = 0; lane < 8; ++lane) {
        const bool isBelow = x[lane] < -0x1p31f;
        EXPECT_EQ(eight[lane], isBelow ? std::numeric_limits<std::int32_t>::max() : kLowest) << x[lane];
        EXPECT_EQ(floorToInt(Float4{x[lane], 0, 0, 0})[0], eight[lane]);
    }
}

TEST(VoxelOf, RoundsToTheNearestCentreAndHalvesUp)
{
    const Int4 voxel = voxelOf(Float4{2.49f, 2.5f, -2.5f, -2.51f});
    EXPECT_EQ(voxel[0], 2);
    EXPECT_EQ(voxel[1], 3);
    EXPECT_EQ(voxel[2], -2);
    EXPECT_EQ(voxel[3], -3);
}

TEST(LoadVectors, TakesThreeComponentsFromEach)
{
    float numbers[24];
    for (int i = 0; i < 24; ++i)
        numbers[i] = float(i);
    const Vector8 vectors = loadVectors(numbers);
    for (int lane = 0; lane < 8; ++lane) {
        const Float4 vector = vectors.lane(lane);
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_EQ(vector[axis], float(3 * lane + axis)) << lane;
    }
}

TEST(Vector, WholeNumbersBecomeTheSameDoubles)
{
    const UnsignedLong4 numbers = {0, 1, 65535, (std::uint64_t(1) << 52) - 1};
    const Double4 doubles = toDoubles(numbers);
    for (int i = 0; i < 4; ++i)
        EXPECT_EQ(doubles[i], double(numbers[i])) << i;
}

TEST(LoadShorts, WidensFourNumbersFromEachPlace)
{
    constexpr std::uint16_t kShorts[] = {0, 1, 0x7fff, 0x8000, 0xffff, 5, 6, 7, 8};
    const Int8 numbers = loadShorts(kShorts + 1, kShorts + 5);
    for (int lane = 0; lane < kLanes; ++lane)
        EXPECT_EQ(numbers[lane], kShorts[lane + 1]);
    EXPECT_EQ(loadShorts(kShorts + 4, kShorts)[0], 0xffff);
    EXPECT_EQ(loadShorts(kShorts + 4, kShorts)[7], 0x8000);
}

} // namespace
} // namespace vdblic
