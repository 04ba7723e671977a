#pragma once

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"

#include <cmath>
#include <cstdint>

namespace vdblic {

/// The upper half of a float: eight bits of precision, the range of a float. Precise enough for directions.
using BFloat16 = std::uint16_t;

VDBLIC_INLINE BFloat16 toBFloat16(float x)
{
    const auto bits = __builtin_bit_cast(std::uint32_t, x);
    return BFloat16((bits + 0x7fff + (bits >> 16 & 1)) >> 16); // to nearest, ties to even
}

/// A cube of numbers: a leaf's 8³ voxels and a rim around them, x slowest.
template<int rim>
struct PaddedLeaf {
    static constexpr int kRim = rim; ///< voxels on each side
    static constexpr int kDim = LeafVoxel::kDim + 2 * rim;
    static constexpr int kSize = kDim * kDim * kDim;
    static constexpr int kY = kDim, kX = kDim * kDim; ///< distances of neighbours along y and x

    /// Index of a voxel. @param x, y, z relative to the leaf's origin, from −rim to 7 + rim
    template<typename Integer>
    [[nodiscard]] VDBLIC_INLINE static constexpr Integer index(Integer x, Integer y, Integer z)
    {
        return ((x + rim) * kDim + y + rim) * kDim + z + rim;
    }
};

/// The texture of a voxel as a share of the range of its leaf's records, in units of 1/65535. A leaf's records reach
/// two voxels beyond it: everything that the gradient at a sample in one of its voxels depends on.
using TextureRecord = std::uint16_t;
using TextureLeaf = PaddedLeaf<2>;

/// What a leaf's records mean: a texture is low + record · perUnit.
struct alignas(8) TextureScale {
    static constexpr float kUnits = 65535;

    float low = 0, perUnit = 0;

    /// A record such that no record below it stands for more than a texture, also after rounding.
    [[nodiscard]] std::int32_t recordAbove(float texture) const
    {
        if (texture < low || !(perUnit > 0)) return 0;
        const float record = std::floor((texture - low) / perUnit) - 1;
        return std::int32_t(record < 0 ? 0 : record < kUnits ? record : kUnits);
    }
};

/// A scalar's values at a leaf's voxels and one voxel around them: all that a sample in one of its voxels depends on.
using ScalarLeaf = PaddedLeaf<1>;

/// The projector on the direction of lines: xx yy zz xy xz yz 0 0, of trace 1. Padded as scalars.
struct alignas(16) LineRecord {
    BFloat16 values[8];
};

} // namespace vdblic
