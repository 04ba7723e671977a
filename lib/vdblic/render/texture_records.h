#pragma once

#include "vdblic/field/domain.h"

#include <cstdint>

namespace vdblic {

/// A number from the upper half of a float: eight bits of precision, the range of a float. Enough for directions.
using HalfFloat = std::uint16_t;

VDBLIC_INLINE HalfFloat halfFloat(float x)
{
    const auto bits = __builtin_bit_cast(std::uint32_t, x);
    return HalfFloat((bits + 0x7fff + (bits >> 16 & 1)) >> 16); // to nearest, ties to even
}

/// What decides whether a sample is seen. Two neighbours along z are loaded at once.
struct alignas(8) ValueRecord {
    float texture, magnitude;
};

/// The gradient of the texture, for samples that are seen. The fourth number is 0.
struct alignas(8) GradientRecord {
    HalfFloat values[4];
};

/// The projector on the lines' direction, xx yy zz xy xz yz, of trace 1; two numbers are 0.
struct alignas(16) LineRecord {
    HalfFloat values[8];
};

/// A leaf's brick of records: its 8³ voxels and one voxel around them, x slowest, so that every cell a sample in one
/// of its voxels can lie in is whole.
inline constexpr int kBrickDim = LeafVoxel::kDim + 2;
inline constexpr int kBrickSize = kBrickDim * kBrickDim * kBrickDim;

/// @param x from −1 to 8, counted from the leaf's origin; so are y and z
template<typename Integer>
constexpr Integer brickIndex(Integer x, Integer y, Integer z)
{
    return ((x + 1) * kBrickDim + y + 1) * kBrickDim + z + 1;
}

} // namespace vdblic
