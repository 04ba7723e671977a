#pragma once

#include "vdblic/core/names.h"

#include <array>
#include <string_view>

namespace vdblic {

/// The side of the domain along which a ground lies: the lowest against up, or the low or high end of a world axis.
enum class GroundSide { kNone, kBelow, kLowX, kHighX, kLowY, kHighY, kLowZ, kHighZ };
template<>
inline constexpr auto kNames<GroundSide> = std::to_array<std::string_view>({"none", "below", "low-x", "high-x", "low-y",
                                                                            "high-y", "low-z", "high-z"});

} // namespace vdblic
