#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/mix_bits.h"
#include "vdblic/field/vector.h"

#include <openvdb/openvdb.h>

#include <cstdint>

namespace vdblic {

/// The largest noise value; values are fixed-point numbers in [0, kNoiseMax], standing for [0, 1].
inline constexpr int kNoiseMax = 65535;

/// White noise: a value for each voxel of index space, uniform in [0, kNoiseMax] and independent of every other.
///
/// A pure function of its arguments: any part of a domain can be computed alone, in any order. A loop over z calls
/// noiseColumn() once; a value then costs one mixing of 64 bits.
VDBLIC_INLINE std::uint64_t noiseColumn(std::int32_t x, std::int32_t y, std::uint32_t seed)
{
    constexpr std::uint64_t kGoldenRatio = 0x9e3779b97f4a7c15u; // keeps the origin at seed 0 off the fixed point 0
    const std::uint64_t column = std::uint64_t(std::uint32_t(x)) << 32 | std::uint32_t(y);
    return mixBits(column + kGoldenRatio) + (std::uint64_t(seed) << 32);
}

/// The value at height z of a column; see noiseColumn().
VDBLIC_INLINE std::uint16_t noiseInColumn(std::uint64_t column, std::int32_t z)
{
    return std::uint16_t(mixBits(column + std::uint32_t(z)) >> 48);
}

/// The values at heights z to z + 7 of a column.
VDBLIC_INLINE Int8 noiseRow(std::uint64_t column, std::int32_t z)
{
    Int4 values[2];
    for (unsigned half = 0; half < 2; ++half) {
        const Unsigned4 heights = Unsigned4{0, 1, 2, 3} + (std::uint32_t(z) + 4 * half);
        const UnsignedLong4 mixed = mixBits(__builtin_convertvector(heights, UnsignedLong4) + column);
        values[half] = __builtin_convertvector(mixed >> 48, Int4);
    }
    return __builtin_shufflevector(values[0], values[1], 0, 1, 2, 3, 4, 5, 6, 7);
}

/// The value of a single voxel; see noiseColumn().
VDBLIC_INLINE std::uint16_t noiseValue(std::int32_t x, std::int32_t y, std::int32_t z, std::uint32_t seed)
{
    return noiseInColumn(noiseColumn(x, y, seed), z);
}

/// The values at the corners of a cube, z the fastest. @param x, y, z first corner  @param edge of the cube
VDBLIC_INLINE Int8 noiseCorners(int x, int y, int z, int edge, std::uint32_t seed)
{
    UnsignedLong4 columns;
    for (int i = 0; i < 4; ++i)
        columns[i] = noiseColumn(x + edge * (i >> 1), y + edge * (i & 1), seed);
    const auto atHeight = [&](int height) {
        return __builtin_convertvector(mixBits(columns + std::uint64_t(std::uint32_t(height))) >> 48, Int4);
    };
    return __builtin_shufflevector(atHeight(z), atHeight(z + edge), 0, 4, 1, 5, 2, 6, 3, 7);
}

/// The noise on the active voxels of a domain, as a grid `noise` of noiseValue() / kNoiseMax; 0 elsewhere.
///
/// @param transform of the grid; the noise itself depends on indices only
/// @return a grid with the metadata `seed` (int64)
/// Computed in parallel.
[[nodiscard]] openvdb::FloatGrid::Ptr makeNoise(const Domain& domain, const openvdb::math::Transform& transform,
                                                std::uint32_t seed);

} // namespace vdblic
