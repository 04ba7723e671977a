#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/methods/streaks/streak.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

/// The seeding controller of streaks: Liu & Moorhead's (2004, section 2.2), with a spacing in place of a voxel, and
/// with hysteresis. A streak is released where none lies within 0.85 spacings; of two within 0.45 the younger retires.
/// So the pattern moves with the flow and changes little. All depends on distances, ages and names alone.

/// Retire the live streaks too near to an older one. @param period of the domain  @return their number
std::size_t retireCrowded(std::vector<Streak>& streaks, const std::array<float, 3>& spacing, double time,
                          const Period& period = {});

/// A place for the release of a streak.
struct StreakPlace {
    std::array<float, 3> position; ///< index space of the velocity
    std::uint64_t name;            ///< of the future streak
};

/// Places for new streaks: a random free one in each cell of a spacing that has any.
///
/// Along an axis where the domain is thinner than a spacing, places are in its middle.
/// @param streaks that already exist
/// @param domain  voxels of the velocity
/// @param region  part of the domain, or all of it, that releases streaks
/// @param seed, turn vary the places between calls
/// @return in ascending order of names. Computed in parallel.
[[nodiscard]] std::vector<StreakPlace> freePlaces(const std::vector<Streak>& streaks,
                                                  const std::array<float, 3>& spacing, const Domain& domain,
                                                  const Domain& region, std::uint32_t seed, std::uint64_t turn);

} // namespace vdblic
