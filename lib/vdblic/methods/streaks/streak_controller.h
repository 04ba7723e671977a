#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/methods/streaks/streak.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

/// The seeding controller of streaks: Liu & Moorhead's (2004, section 2.2), at a distance of a spacing instead of a
/// voxel, and with hysteresis. A streak is released where none lies within 0.85 spacings; of two within 0.45 the
/// younger retires. So the pattern moves with the flow, and little of it changes. Everything depends on distances, ages
/// and names alone.

/// Retire the live streaks that have come too near to an older one. @return their number
std::size_t retireCrowded(std::vector<Streak>& streaks, const std::array<float, 3>& spacing, double time);

/// A place where a streak may be released.
struct StreakPlace {
    std::array<float, 3> position; ///< index space of the velocity
    std::uint64_t name;            ///< of the streak to be
};

/// Places for new streaks: one in each cell of a spacing in which one is free, at random there.
///
/// Along an axis on which the domain is thinner than a spacing, places are in its middle.
/// @param streaks that live already
/// @param domain  voxels of the velocity
/// @param region  the part of the domain that releases; the domain itself if all of it does
/// @param seed, turn give each call its own places
/// @return in ascending order of names. Computed in parallel.
[[nodiscard]] std::vector<StreakPlace> freePlaces(const std::vector<Streak>& streaks,
                                                  const std::array<float, 3>& spacing, const Domain& domain,
                                                  const Domain& region, std::uint32_t seed, std::uint64_t turn);

} // namespace vdblic
