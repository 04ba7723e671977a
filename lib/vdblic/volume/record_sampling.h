#pragma once

#include "vdblic/field/vector.h"
#include "vdblic/volume/texture_records.h"

#include <cstdint>
#include <cstring>

namespace vdblic {

/// Eight numbers as floats.
VDBLIC_INLINE Float8 loadBFloat16s(const BFloat16* values)
{
    using Short8 = BFloat16 __attribute__((vector_size(16)));
    using Bits8 = std::uint32_t __attribute__((vector_size(32)));
    Short8 upper;
    std::memcpy(&upper, values, sizeof upper);
    return __builtin_bit_cast(Float8, __builtin_convertvector(upper, Bits8) << 16);
}

VDBLIC_INLINE Float8 mix(Float8 from, Float8 to, Float8 share)
{
    return from + (to - from) * share;
}

/// The records at a corner and at its neighbour along z, of two cells.
template<typename Record>
VDBLIC_INLINE Float8 loadPairs(const Record* a, const Record* b)
{
    Float4 first, second;
    static_assert(sizeof first == 2 * sizeof(Record));
    std::memcpy(&first, a, sizeof first);
    std::memcpy(&second, b, sizeof second);
    return __builtin_shufflevector(first, second, 0, 1, 2, 3, 4, 5, 6, 7);
}

/// Records interpolated over x and y, at both ends along z, in the cells of lanes i and i + 4.
///
/// @param record   indices of the records at the cells' lowest corners
/// @param fraction positions in the cells, 0 to 1, by axis
/// @param read     turns what loadPairs() returns into numbers
template<int i, typename Record, typename Read>
VDBLIC_INLINE Float8 mixAcross(const Record* records, Unsigned8 record, const Float8* fraction, const Read& read)
{
    constexpr int kY = kPaddedDim, kX = kPaddedDim * kPaddedDim;
    const auto corner = [&](int at) { return read(loadPairs(records + record[i] + at, records + record[i + 4] + at)); };
    const auto spread = [](Float8 x) { return __builtin_shufflevector(x, x, i, i, i, i, i + 4, i + 4, i + 4, i + 4); };
    const Float8 x = spread(fraction[0]), y = spread(fraction[1]);
    return mix(mix(corner(0), corner(kY), y), mix(corner(kX), corner(kX + kY), y), x);
}

/// Trilinear interpolation in eight cells. Parameters as mixAcross() has them.
/// @param read   returns four numbers for a pair of records, two for each
/// @param result receives the two interpolated numbers
template<typename Record, typename Read>
VDBLIC_INLINE void sampleRecords(const Record* records, Unsigned8 record, const Float8* fraction, const Read& read,
                                 Float8* result)
{
    const Float8 pairs[] = {
        mixAcross<0>(records, record, fraction, read), mixAcross<1>(records, record, fraction, read),
        mixAcross<2>(records, record, fraction, read), mixAcross<3>(records, record, fraction, read)};
    Float8 ends[4];
    transposePairs(pairs, ends);
    result[0] = mix(ends[0], ends[2], fraction[2]);
    result[1] = mix(ends[1], ends[3], fraction[2]);
}

/// Texture and driver of eight samples.
VDBLIC_INLINE void sampleValues(const ValueRecord* values, Unsigned8 record, const Float8* fraction, Float8* result)
{
    sampleRecords(
        values, record, fraction, [](Float8 both) { return both; }, result);
}

/// The gradients of eight samples.
VDBLIC_INLINE void sampleGradients(const GradientRecord* gradients, Unsigned8 record, const Float8* fraction,
                                   Float8* result)
{
    // A word of 32 bits holds two numbers: the even one in its lower half, the odd one in its upper half.
    const auto even = [](Float8 both) { return __builtin_bit_cast(Float8, __builtin_bit_cast(Int8, both) << 16); };
    const auto odd = [](Float8 both) {
        return __builtin_bit_cast(Float8, __builtin_bit_cast(Int8, both) & int(0xffff0000));
    };
    Float8 xz[2], y[2];
    sampleRecords(gradients, record, fraction, even, xz);
    sampleRecords(gradients, record, fraction, odd, y);
    result[0] = xz[0];
    result[1] = y[0];
    result[2] = xz[1];
}

/// Trilinear interpolation of single numbers in eight cells.
VDBLIC_INLINE Float8 sampleNumbers(const float* numbers, Unsigned8 record, const Float8* fraction)
{
    constexpr unsigned kY = kPaddedDim, kX = kPaddedDim * kPaddedDim;
    const auto corner = [&](unsigned at) {
        Float8 result;
        for (int lane = 0; lane < kLanes; ++lane)
            result[lane] = numbers[record[lane] + at];
        return result;
    };
    const auto edge = [&](unsigned at) { return mix(corner(at), corner(at + 1), fraction[2]); };
    return mix(mix(edge(0), edge(kY), fraction[1]), mix(edge(kX), edge(kX + kY), fraction[1]), fraction[0]);
}

/// Trilinear interpolation of the line projectors in one cell. @param x, y, z position in the cell, 0 to 1
VDBLIC_INLINE Float8 sampleLine(const LineRecord* corner, float x, float y, float z)
{
    constexpr int kY = kPaddedDim, kX = kPaddedDim * kPaddedDim;
    const auto pair = [&](int i) {
        return mix(loadBFloat16s(corner[i].values), loadBFloat16s(corner[i + 1].values), broadcast8(z));
    };
    return mix(mix(pair(0), pair(kY), broadcast8(y)), mix(pair(kX), pair(kX + kY), broadcast8(y)), broadcast8(x));
}

} // namespace vdblic
