#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/neighbourhood_grid.h"
#include "vdblic/methods/streaks/streak.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

/// The seeding controller of streaks: Liu & Moorhead's (2004, section 2.2), with a spacing in place of a voxel, and
/// with hysteresis. A streak is released where none lies within 0.85 spacings; of two within 0.45 the younger retires.
/// So the pattern moves with the flow and changes little. All depends on distances, ages and names alone.

/// Add the heads of live streaks to a grid, by the numbers of the streaks. @param first streak that is not yet there
void addLive(const std::vector<Streak>& streaks, std::size_t first, NeighbourhoodGrid& heads);

/// Retire the live streaks too near to an older one. @param heads of all live streaks  @return their number
std::size_t retireCrowded(std::vector<Streak>& streaks, const NeighbourhoodGrid& heads, double time);

/// A place for the release of a streak.
struct StreakPlace {
    std::array<float, 3> position; ///< index space of the velocity
    std::uint64_t name;            ///< of the future streak
};

/// Places for new streaks: a random free one in each cell of a spacing that has any.
///
/// Along an axis where the domain is thinner than a spacing, places are in its middle.
/// @param streaks, heads that already exist; heads of streaks that have retired are no matter
/// @param domain  voxels of the velocity
/// @param region  part of the domain, or all of it, that releases streaks
/// @param seed, turn vary the places between calls
/// @return in the order of the region's leaves. Computed in parallel.
[[nodiscard]] std::vector<StreakPlace> freePlaces(const std::vector<Streak>& streaks, const NeighbourhoodGrid& heads,
                                                  const std::array<float, 3>& spacing, const Domain& domain,
                                                  const Domain& region, std::uint32_t seed, std::uint64_t turn);

} // namespace vdblic
