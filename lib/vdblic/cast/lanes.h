#pragma once

#include "vdblic/field/vector.h"

#include <array>

namespace vdblic {

/// 2^x for x ≤ 0, to a relative error of 3e-6 and exact at 0: 2^i · e^(f ln 2), |f| ≤ ½. The Taylor polynomial of
/// degree 5 is evaluated by Estrin's scheme (1960), whose dependency chain is short.
VDBLIC_INLINE Float8 powerOfTwo(Float8 x)
{
    const Float8 power = x > -126 ? x : broadcast8(-126);
    constexpr float kRound = 0x1.8p23f + 127; // adding it rounds to an integer and leaves that, biased, in the low bits
    const Float8 rounded = power + kRound;
    const Float8 t = (power - (rounded - kRound)) * 0.693147181f;
    const Float8 square = t * t;
    const Float8 series = (1 + t) + square * ((1 / 2.0f + t * (1 / 6.0f)) + square * (1 / 24.0f + t * (1 / 120.0f)));
    return series * __builtin_bit_cast(Float8, __builtin_bit_cast(Int8, rounded) << 23);
}

/// Set one lane by loading and storing the whole vector: after a store of a single lane the next load of the vector
/// would stall.
VDBLIC_INLINE void setLane(Float8& vector, int lane, float value)
{
    constexpr Int8 kNumbers = {0, 1, 2, 3, 4, 5, 6, 7};
    vector = kNumbers == lane ? broadcast8(value) : vector;
}
VDBLIC_INLINE void setLane(Int8& vector, int lane, int value)
{
    constexpr Int8 kNumbers = {0, 1, 2, 3, 4, 5, 6, 7};
    vector = kNumbers == lane ? broadcastInt8(value) : vector;
}

VDBLIC_INLINE Float8 positive(Float8 x)
{
    return x > 0 ? x : Float8{};
}

/// Between 0 and 1; 0 for NaN.
VDBLIC_INLINE Float8 clamped(Float8 x)
{
    return positive(x < 1 ? x : broadcast8(1));
}

/// The lanes of a vector in another order. @param order number of the lane that each lane receives
VDBLIC_INLINE Int8 permuted(Int8 x, Int8 order)
{
#ifdef __clang__
    return __builtin_shufflevector(x, order);
#else
    return __builtin_shuffle(x, order);
#endif
}

/// For each set of lanes, a permutation that moves them to the front in rising order.
struct Packing {
    Int8 order[256]{};

    constexpr Packing()
    {
        for (unsigned bits = 0; bits < 256; ++bits) {
            int lanes[kLanes] = {};
            int count = 0;
            for (int lane = 0; lane < kLanes; ++lane) {
                if (bits >> lane & 1) lanes[count++] = lane;
            }
            order[bits] = Int8{lanes[0], lanes[1], lanes[2], lanes[3], lanes[4], lanes[5], lanes[6], lanes[7]};
        }
    }
    VDBLIC_INLINE Int8 operator[](unsigned bits) const { return order[bits]; }
};
inline constexpr Packing kPacking;

/// Four columns of eight numbers into eight rows.
VDBLIC_INLINE void transposeBack(const Float8* columns, Float4* rows)
{
    const Float8 a = __builtin_shufflevector(columns[0], columns[1], 0, 8, 1, 9, 4, 12, 5, 13);
    const Float8 b = __builtin_shufflevector(columns[0], columns[1], 2, 10, 3, 11, 6, 14, 7, 15);
    const Float8 c = __builtin_shufflevector(columns[2], columns[3], 0, 8, 1, 9, 4, 12, 5, 13);
    const Float8 d = __builtin_shufflevector(columns[2], columns[3], 2, 10, 3, 11, 6, 14, 7, 15);
    const Float8 joined[4] = {__builtin_shufflevector(a, c, 0, 1, 8, 9, 4, 5, 12, 13),
                              __builtin_shufflevector(a, c, 2, 3, 10, 11, 6, 7, 14, 15),
                              __builtin_shufflevector(b, d, 0, 1, 8, 9, 4, 5, 12, 13),
                              __builtin_shufflevector(b, d, 2, 3, 10, 11, 6, 7, 14, 15)};
    for (int i = 0; i < 4; ++i) {
        rows[i] = __builtin_shufflevector(joined[i], joined[i], 0, 1, 2, 3);
        rows[i + 4] = __builtin_shufflevector(joined[i], joined[i], 4, 5, 6, 7);
    }
}

} // namespace vdblic
