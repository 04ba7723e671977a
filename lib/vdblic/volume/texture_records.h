#pragma once

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"

#include <cstdint>

namespace vdblic {

/// The upper half of a float: eight bits of precision, the range of a float. Precise enough for directions.
using BFloat16 = std::uint16_t;

VDBLIC_INLINE BFloat16 toBFloat16(float x)
{
    const auto bits = __builtin_bit_cast(std::uint32_t, x);
    return BFloat16((bits + 0x7fff + (bits >> 16 & 1)) >> 16); // to nearest, ties to even
}

/// What the opacity of a sample depends on. Two neighbours along z are loaded at once.
struct alignas(8) ValueRecord {
    float texture, driver;
};

/// The gradient of the texture, for visible samples. The fourth number is 0.
struct alignas(8) GradientRecord {
    BFloat16 values[4];
};

/// The projector on the direction of lines: xx yy zz xy xz yz 0 0, of trace 1.
struct alignas(16) LineRecord {
    BFloat16 values[8];
};

/// A padded leaf: records of a leaf's 8³ voxels and of one voxel around them, x slowest. It holds all corners of every
/// cell that a sample in one of the leaf's voxels can lie in.
inline constexpr int kPaddedDim = LeafVoxel::kDim + 2;
inline constexpr int kPaddedSize = kPaddedDim * kPaddedDim * kPaddedDim;

/// Index of a record in its padded leaf. @param x, y, z from −1 to 8, relative to the leaf's origin
template<typename Integer>
constexpr Integer paddedIndex(Integer x, Integer y, Integer z)
{
    return ((x + 1) * kPaddedDim + y + 1) * kPaddedDim + z + 1;
}

} // namespace vdblic
