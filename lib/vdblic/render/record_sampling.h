#pragma once

#include "vdblic/field/vector.h"
#include "vdblic/render/texture_records.h"

#include <cstring>

namespace vdblic {

/// Eight half floats.
VDBLIC_INLINE Float8 loadHalfFloats(const HalfFloat* values)
{
    using Half8 = HalfFloat __attribute__((vector_size(16)));
    using Bits8 = std::uint32_t __attribute__((vector_size(32)));
    Half8 halves;
    std::memcpy(&halves, values, sizeof halves);
    return __builtin_bit_cast(Float8, __builtin_convertvector(halves, Bits8) << 16);
}

/// Trilinear interpolation of gradients, in one of them for each half of a vector.
struct GradientPair {
    Float8 xz, y; ///< x z · ·, and y · · ·, of the one and of the other
};

/// @param a, b records at the cells' lowest corners; x, y, z places in the cells, 0 to 1, four times each
VDBLIC_INLINE GradientPair sampleGradients(const GradientRecord* a, const GradientRecord* b, Float8 x, Float8 y,
                                           Float8 z)
{
    constexpr int kY = kBrickDim, kX = kBrickDim * kBrickDim;
    // A corner and its neighbour along z: the numbers at even and at odd places are the halves of 32 bits.
    const auto load = [&](int i) {
        Int4 first, second;
        std::memcpy(&first, a + i, sizeof first);
        std::memcpy(&second, b + i, sizeof second);
        return __builtin_shufflevector(first, second, 0, 1, 2, 3, 4, 5, 6, 7);
    };
    const auto even = [](Int8 both) { return __builtin_bit_cast(Float8, both << 16); };
    const auto odd = [](Int8 both) { return __builtin_bit_cast(Float8, both & int(0xffff0000)); };
    const auto mix = [](Float8 from, Float8 to, Float8 t) { return from + (to - from) * t; };
    const auto along = [&](Float8 v) { return mix(v, __builtin_shufflevector(v, v, 2, 3, 2, 3, 6, 7, 6, 7), z); };
    const Int8 c00 = load(0), c01 = load(kY), c10 = load(kX), c11 = load(kX + kY);
    return {along(mix(mix(even(c00), even(c01), y), mix(even(c10), even(c11), y), x)),
            along(mix(mix(odd(c00), odd(c01), y), mix(odd(c10), odd(c11), y), x))};
}

/// The gradients of eight samples. @param record numbers of the records at the cells' lowest corners
VDBLIC_INLINE void sampleGradients(const GradientRecord* gradients, const unsigned* record, const float* x,
                                   const float* y, const float* z, Float8* result)
{
    GradientPair pairs[4];
    for (int a = 0; a < 4; ++a) {
        const int b = a + 4;
        const auto both = [&](const float* values) {
            const Float4 low = broadcast4(values[a]), high = broadcast4(values[b]);
            return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
        };
        pairs[a] = sampleGradients(gradients + record[a], gradients + record[b], both(x), both(y), both(z));
    }
    const auto interleave = [](Float8 p, Float8 q) { return __builtin_shufflevector(p, q, 0, 8, 1, 9, 4, 12, 5, 13); };
    const auto front = [](Float8 p, Float8 q) { return __builtin_shufflevector(p, q, 0, 1, 8, 9, 4, 5, 12, 13); };
    const auto back = [](Float8 p, Float8 q) { return __builtin_shufflevector(p, q, 2, 3, 10, 11, 6, 7, 14, 15); };
    const Float8 xz[] = {interleave(pairs[0].xz, pairs[1].xz), interleave(pairs[2].xz, pairs[3].xz)};
    result[0] = front(xz[0], xz[1]);
    result[1] = front(interleave(pairs[0].y, pairs[1].y), interleave(pairs[2].y, pairs[3].y));
    result[2] = back(xz[0], xz[1]);
}

/// Trilinear interpolation of line directions.
VDBLIC_INLINE Float8 sampleLine(const LineRecord* corner, float x, float y, float z)
{
    constexpr int kY = kBrickDim, kX = kBrickDim * kBrickDim;
    const auto mix = [](Float8 a, Float8 b, float t) { return a + (b - a) * t; };
    const auto pair = [&](int i) {
        return mix(loadHalfFloats(corner[i].values), loadHalfFloats(corner[i + 1].values), z);
    };
    return mix(mix(pair(0), pair(kY), y), mix(pair(kX), pair(kX + kY), y), x);
}

} // namespace vdblic
