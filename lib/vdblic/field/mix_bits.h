#pragma once

#include "vdblic/field/vector.h"

#include <cstdint>

namespace vdblic {

/// A bijection of 64-bit numbers in which every bit of the argument changes every bit of the result with
/// probability ½: the finaliser of SplitMix64 (Steele, Lea & Flood, "Fast splittable pseudorandom number
/// generators", OOPSLA 2014), with the constants of D. Stafford's "Mix13".
/// @param bits one number, a std::uint64_t, or one a lane, an UnsignedLong4
template<typename Bits>
VDBLIC_INLINE Bits mixBits(Bits bits)
{
    static_assert(sizeof bits % 8 == 0);
    bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9u;
    bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebu;
    return bits ^ (bits >> 31);
}

} // namespace vdblic
