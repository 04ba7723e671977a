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

VDBLIC_INLINE Float8 mix(Float8 from, Float8 to, Float8 share)
{
    return from + (to - from) * share;
}

/// The records at a corner and at its neighbour along z, of one cell and of another.
template<typename Record>
VDBLIC_INLINE Float8 loadPairs(const Record* a, const Record* b)
{
    Float4 first, second;
    static_assert(sizeof first == 2 * sizeof(Record));
    std::memcpy(&first, a, sizeof first);
    std::memcpy(&second, b, sizeof second);
    return __builtin_shufflevector(first, second, 0, 1, 2, 3, 4, 5, 6, 7);
}

/// Four cells' edges along z: records mixed across x and y.
///
/// @param i      of the cells of lanes i and i + 4
/// @param record numbers of the records at the cells' lowest corners
/// @param place  in the cells, 0 to 1, by axis
/// @param read   turns what loadPairs() finds into numbers
template<int i, typename Record, typename Read>
VDBLIC_INLINE Float8 mixAcross(const Record* records, Unsigned8 record, const Float8* place, const Read& read)
{
    constexpr int kY = kBrickDim, kX = kBrickDim * kBrickDim;
    const auto corner = [&](int at) { return read(loadPairs(records + record[i] + at, records + record[i + 4] + at)); };
    const auto spread = [](Float8 x) { return __builtin_shufflevector(x, x, i, i, i, i, i + 4, i + 4, i + 4, i + 4); };
    const Float8 x = spread(place[0]), y = spread(place[1]);
    return mix(mix(corner(0), corner(kY), y), mix(corner(kX), corner(kX + kY), y), x);
}

/// Trilinear interpolation in eight cells of what `read` finds: four numbers to a pair of records, those of the first
/// before those of the second. @param result the two numbers
template<typename Record, typename Read>
VDBLIC_INLINE void sampleRecords(const Record* records, Unsigned8 record, const Float8* place, const Read& read,
                                 Float8* result)
{
    const Float8 pairs[] = {mixAcross<0>(records, record, place, read), mixAcross<1>(records, record, place, read),
                            mixAcross<2>(records, record, place, read), mixAcross<3>(records, record, place, read)};
    Float8 ends[4];
    transposePairs(pairs, ends);
    result[0] = mix(ends[0], ends[2], place[2]);
    result[1] = mix(ends[1], ends[3], place[2]);
}

/// Texture and magnitude of eight samples.
VDBLIC_INLINE void sampleValues(const ValueRecord* values, Unsigned8 record, const Float8* place, Float8* result)
{
    sampleRecords(
        values, record, place, [](Float8 both) { return both; }, result);
}

/// The gradients of eight samples.
VDBLIC_INLINE void sampleGradients(const GradientRecord* gradients, Unsigned8 record, const Float8* place,
                                   Float8* result)
{
    // The numbers at even and at odd places are the halves of 32 bits.
    const auto even = [](Float8 both) { return __builtin_bit_cast(Float8, __builtin_bit_cast(Int8, both) << 16); };
    const auto odd = [](Float8 both) {
        return __builtin_bit_cast(Float8, __builtin_bit_cast(Int8, both) & int(0xffff0000));
    };
    Float8 xz[2], y[2];
    sampleRecords(gradients, record, place, even, xz);
    sampleRecords(gradients, record, place, odd, y);
    result[0] = xz[0];
    result[1] = y[0];
    result[2] = xz[1];
}

/// Trilinear interpolation of line directions.
VDBLIC_INLINE Float8 sampleLine(const LineRecord* corner, float x, float y, float z)
{
    constexpr int kY = kBrickDim, kX = kBrickDim * kBrickDim;
    const auto pair = [&](int i) {
        return mix(loadHalfFloats(corner[i].values), loadHalfFloats(corner[i + 1].values), broadcast8(z));
    };
    return mix(mix(pair(0), pair(kY), broadcast8(y)), mix(pair(kX), pair(kX + kY), broadcast8(y)), broadcast8(x));
}

} // namespace vdblic
