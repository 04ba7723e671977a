#pragma once

#include <cstdint>

namespace vdblic {

/// Short vectors of the compiler's vector extension: arithmetic and comparison act per lane, on any processor.
using Float4 = float __attribute__((vector_size(16)));
using Float8 = float __attribute__((vector_size(32)));
using Int4 = std::int32_t __attribute__((vector_size(16)));
using Int8 = std::int32_t __attribute__((vector_size(32)));

/// Functions that hot loops are made of: always merged into their caller, so that they take on its instruction set.
#define VDBLIC_INLINE [[gnu::always_inline]] inline

/// Functions that hold a hot loop: compiled for AVX2 and AVX-512 besides the baseline, the version chosen when the
/// program is loaded. All give equal bits: nothing in this project may be contracted or reassociated.
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define VDBLIC_KERNEL [[gnu::flatten, gnu::target_clones("avx512f", "avx2", "default")]]
#else
#define VDBLIC_KERNEL
#endif

VDBLIC_INLINE Float4 broadcast4(float x)
{
    return Float4{x, x, x, x};
}
VDBLIC_INLINE Float8 broadcast8(float x)
{
    return Float8{x, x, x, x, x, x, x, x};
}

/// The largest integers not above x, for |x| < 2³¹.
VDBLIC_INLINE Int4 floorToInt(Float4 x)
{
    const Int4 truncated = __builtin_convertvector(x, Int4);
    return truncated + (x < __builtin_convertvector(truncated, Float4)); // a true comparison is −1
}
VDBLIC_INLINE Int8 floorToInt(Float8 x)
{
    const Int8 truncated = __builtin_convertvector(x, Int8);
    return truncated + (x < __builtin_convertvector(truncated, Float8));
}

/// The voxel a position lies in; centres are at integers, so voxel i covers [i − ½, i + ½).
VDBLIC_INLINE Int4 voxelOf(Float4 position)
{
    return floorToInt(position + 0.5f);
}

} // namespace vdblic
