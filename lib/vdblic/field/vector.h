#pragma once

#include "vdblic/field/inlined.h"

#include <cstdint>
#include <limits>

namespace vdblic {

/// Short vectors of the compiler's vector extension: arithmetic and comparison act per lane, on any processor. Vectors
/// of 32 bytes are aligned to 32: the baseline would not ask for it, but kernels for AVX do. The compiler would take
/// wider vectors apart into scalars.
using Float2 = float __attribute__((vector_size(8), aligned(8)));
using Float4 = float __attribute__((vector_size(16)));
using Float8 = float __attribute__((vector_size(32), aligned(32)));
using Int4 = std::int32_t __attribute__((vector_size(16)));
using Int8 = std::int32_t __attribute__((vector_size(32), aligned(32)));
using Unsigned4 = std::uint32_t __attribute__((vector_size(16)));
using Unsigned8 = std::uint32_t __attribute__((vector_size(32), aligned(32)));
using Double2 = double __attribute__((vector_size(16)));
using Double4 = double __attribute__((vector_size(32), aligned(32)));
using Long2 = std::int64_t __attribute__((vector_size(16)));
using UnsignedLong4 = std::uint64_t __attribute__((vector_size(32), aligned(32)));
using Long4 = std::int64_t __attribute__((vector_size(32), aligned(32)));

/// Particles or rays processed side by side: enough loads in flight to hide the memory's latency.
inline constexpr int kLanes = 8;

/// For functions with a hot loop: compiled for the baseline, AVX2 and AVX-512; the program loader chooses. All versions
/// give equal bits, because nothing in this project is contracted or reassociated.
#if defined(__x86_64__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define VDBLIC_KERNEL [[gnu::flatten, gnu::target_clones("avx512f", "avx2", "default")]]
#else
#define VDBLIC_KERNEL
#endif

VDBLIC_INLINE Float4 broadcast4(float x)
{
    return Float4{x, x, x, x};
}
/// A number in every lane. Filled lane by lane it compiles to one instruction; GCC 12 turns a list into eight.
VDBLIC_INLINE Float8 broadcast8(float x)
{
    Float8 all{};
    for (int lane = 0; lane < 8; ++lane)
        all[lane] = x;
    return all;
}
VDBLIC_INLINE Int8 broadcastInt8(int x)
{
    Int8 all{};
    for (int lane = 0; lane < 8; ++lane)
        all[lane] = x;
    return all;
}

/// Numbers truncated to integers; −2³¹ for NaN and numbers out of range. x86-64 does so itself; other processors
/// saturate, and give 0 for NaN.
template<typename Ints, typename Floats>
VDBLIC_INLINE Ints truncated(Floats x)
{
    const Ints ints = __builtin_convertvector(x, Ints);
#ifdef __x86_64__
    return ints;
#else
    const Ints isHeld = (x >= -0x1p31f) & (x < 0x1p31f);
    return isHeld ? ints : Ints{} + std::numeric_limits<std::int32_t>::min();
#endif
}

/// The largest integers not above x, for |x| < 2³¹; beyond and for not-a-number, the lowest or highest int.
VDBLIC_INLINE Int4 floorToInt(Float4 x)
{
    const auto whole = truncated<Int4>(x);
    const Int4 below = x < __builtin_convertvector(whole, Float4); // true is −1
    return Int4(Unsigned4(whole) + Unsigned4(below));
}
VDBLIC_INLINE Int8 floorToInt(Float8 x)
{
    const auto whole = truncated<Int8>(x);
    const Int8 below = x < __builtin_convertvector(whole, Float8);
    return Int8(Unsigned8(whole) + Unsigned8(below));
}

/// Whole numbers below 2⁵² as doubles: no processor before AVX-512 converts them.
VDBLIC_INLINE Double4 toDoubles(UnsignedLong4 x)
{
    constexpr std::uint64_t kExponent = std::uint64_t(1023 + 52) << 52; // of 2⁵², whose lowest bit is 1
    return Double4(x | kExponent) - 0x1p52;
}

/// Whether any lane of a comparison's result is true.
VDBLIC_INLINE bool anyOf(Int8 mask)
{
    const Int4 halves =
        __builtin_shufflevector(mask, mask, 0, 1, 2, 3) | __builtin_shufflevector(mask, mask, 4, 5, 6, 7);
    const auto words = reinterpret_cast<Long2>(halves);
    return (words[0] | words[1]) != 0;
}

/// The lanes of a vector in memory, for loops that take one after the other: a load is quicker than an extraction.
template<typename VectorT, typename Number>
VDBLIC_INLINE void storeLanes(VectorT vector, Number (&lanes)[8])
{
    static_assert(sizeof lanes == sizeof vector);
    __builtin_memcpy(&lanes, &vector, sizeof vector);
    asm("" : "+m"(lanes)); // keeps the compiler from extracting from the register
}

/// Numbers of 16 bits, four from each of two places.
VDBLIC_INLINE Int8 loadShorts(const std::uint16_t* first, const std::uint16_t* second)
{
    using Short16 = std::uint16_t __attribute__((vector_size(32), aligned(32)));
    std::uint64_t fours[2];
    __builtin_memcpy(&fours[0], first, sizeof fours[0]);
    __builtin_memcpy(&fours[1], second, sizeof fours[1]);
    // A zero behind each number: one shuffle within the halves of a register. GCC 12 converts eight in four steps.
    const auto numbers = __builtin_bit_cast(Short16, UnsignedLong4{fours[0], 0, fours[1], 0});
    return __builtin_bit_cast(
        Int8, __builtin_shufflevector(numbers, Short16{}, 0, 16, 1, 17, 2, 18, 3, 19, 8, 24, 9, 25, 10, 26, 11, 27));
}

/// A comparison's result that is true in the lanes whose bits are set.
VDBLIC_INLINE Int8 maskOf(unsigned lanes)
{
    return (broadcastInt8(int(lanes)) & Int8{1, 2, 4, 8, 16, 32, 64, 128}) != 0;
}

/// A bit for each negative lane; a true comparison is negative.
VDBLIC_INLINE unsigned laneBits(Int8 x)
{
#ifdef __SSE__
    const auto low = __builtin_bit_cast(Float4, __builtin_shufflevector(x, x, 0, 1, 2, 3));
    const auto high = __builtin_bit_cast(Float4, __builtin_shufflevector(x, x, 4, 5, 6, 7));
    return unsigned(__builtin_ia32_movmskps(low)) | unsigned(__builtin_ia32_movmskps(high)) << 4;
#else
    unsigned bits = 0;
    for (int lane = 0; lane < kLanes; ++lane)
        bits |= unsigned(x[lane] < 0) << lane;
    return bits;
#endif
}

VDBLIC_INLINE Float8 squareRoots(Float8 x)
{
    Float8 root;
    for (int lane = 0; lane < 8; ++lane)
        root[lane] = __builtin_sqrtf(x[lane]);
    return root;
}

/// Eight vectors of three components, one vector a lane.
struct Vector8 {
    Float8 x, y, z;

    [[nodiscard]] VDBLIC_INLINE Float4 lane(int i) const { return Float4{x[i], y[i], z[i], 0}; }
    VDBLIC_INLINE void setLane(int i, Float4 v)
    {
        x[i] = v[0];
        y[i] = v[1];
        z[i] = v[2];
    }
};
VDBLIC_INLINE Vector8 operator+(const Vector8& a, const Vector8& b)
{
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
VDBLIC_INLINE Vector8 operator-(const Vector8& a, const Vector8& b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
VDBLIC_INLINE Vector8 operator*(const Vector8& a, Float8 scale)
{
    return {a.x * scale, a.y * scale, a.z * scale};
}
VDBLIC_INLINE Vector8 operator*(const Vector8& a, float scale)
{
    return {a.x * scale, a.y * scale, a.z * scale};
}
VDBLIC_INLINE Vector8 select(Int8 mask, const Vector8& a, const Vector8& b)
{
    return {mask ? a.x : b.x, mask ? a.y : b.y, mask ? a.z : b.z};
}
VDBLIC_INLINE Float8 squaredLength(const Vector8& a)
{
    return a.x * a.x + a.y * a.y + a.z * a.z;
}

/// Eight vectors that follow one another in memory.
VDBLIC_INLINE Vector8 loadVectors(const float* from)
{
    Float4 parts[6];
    __builtin_memcpy(&parts, from, sizeof parts);
    const auto join = [&](int i) { return __builtin_shufflevector(parts[i], parts[i + 3], 0, 1, 2, 3, 4, 5, 6, 7); };
    const Float8 a = join(0), b = join(1), c = join(2); // x0 y0 z0 x1, y1 z1 x2 y2, z2 x3 y3 z3, and those from 4 on
    const Float8 xy = __builtin_shufflevector(b, c, 2, 3, 9, 10, 6, 7, 13, 14); // x2 y2 x3 y3
    const Float8 yz = __builtin_shufflevector(a, b, 1, 2, 8, 9, 5, 6, 12, 13);  // y0 z0 y1 z1
    return {__builtin_shufflevector(a, xy, 0, 3, 8, 10, 4, 7, 12, 14),
            __builtin_shufflevector(yz, xy, 0, 2, 9, 11, 4, 6, 13, 15),
            __builtin_shufflevector(yz, c, 1, 3, 8, 11, 5, 7, 12, 15)};
}

/// Turn eight rows of eight numbers into eight columns, in place if `columns` is `rows`.
VDBLIC_INLINE void transpose(const Float8* rows, Float8* columns)
{
    Float8 pairs[8], quads[8];
    for (int i = 0; i < 8; i += 2) {
        pairs[i] = __builtin_shufflevector(rows[i], rows[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
        pairs[i + 1] = __builtin_shufflevector(rows[i], rows[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
    }
    for (int i = 0; i < 8; i += 4) {
        for (int j = 0; j < 2; ++j) {
            quads[i + 2 * j] = __builtin_shufflevector(pairs[i + j], pairs[i + j + 2], 0, 1, 8, 9, 4, 5, 12, 13);
            quads[i + 2 * j + 1] = __builtin_shufflevector(pairs[i + j], pairs[i + j + 2], 2, 3, 10, 11, 6, 7, 14, 15);
        }
    }
    for (int i = 0; i < 4; ++i) {
        columns[i] = __builtin_shufflevector(quads[i], quads[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
        columns[i + 4] = __builtin_shufflevector(quads[i], quads[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
    }
}

/// Turn eight rows of four numbers, row i beside row i + 4, into four columns.
VDBLIC_INLINE void transposePairs(const Float8* pairs, Float8* columns)
{
    const Float8 a = __builtin_shufflevector(pairs[0], pairs[1], 0, 8, 1, 9, 4, 12, 5, 13);
    const Float8 b = __builtin_shufflevector(pairs[2], pairs[3], 0, 8, 1, 9, 4, 12, 5, 13);
    const Float8 c = __builtin_shufflevector(pairs[0], pairs[1], 2, 10, 3, 11, 6, 14, 7, 15);
    const Float8 d = __builtin_shufflevector(pairs[2], pairs[3], 2, 10, 3, 11, 6, 14, 7, 15);
    columns[0] = __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13);
    columns[1] = __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
    columns[2] = __builtin_shufflevector(c, d, 0, 1, 8, 9, 4, 5, 12, 13);
    columns[3] = __builtin_shufflevector(c, d, 2, 3, 10, 11, 6, 7, 14, 15);
}
/// Turn eight rows of four numbers into four columns.
VDBLIC_INLINE void transpose(const Float4* rows, Float8* columns)
{
    Float8 pairs[4];
    for (int i = 0; i < 4; ++i)
        pairs[i] = __builtin_shufflevector(rows[i], rows[i + 4], 0, 1, 2, 3, 4, 5, 6, 7);
    transposePairs(pairs, columns);
}

/// The voxel that a position lies in; centres are at integers, so voxel i covers [i − ½, i + ½).
VDBLIC_INLINE Int4 voxelOf(Float4 position)
{
    return floorToInt(position + 0.5f);
}

} // namespace vdblic
