#pragma once

#include "vdblic/methods/streaks/streak.h"
#include "vdblic/methods/streaks/streak_shape.h"

#include <array>
#include <cstdint>
#include <vector>

namespace vdblic {

/// A straight piece of a streak. Positions are in the texture's index space.
struct StreakPiece {
    std::array<float, 3> start, end;
    float startValue, endValue;
    float startWidth, endWidth; ///< relative to the head's
    std::uint32_t streak;
    bool isHead; ///< whether the streak ends here
};

/// Darker voxels are invisible, and not drawn.
inline constexpr float kLeastStreakValue = 0.02f;
/// Thickness at the tail's end, relative to the head's.
inline constexpr float kTailWidth = 0.45f;

/// The visible tails of streaks at a time, cut into pieces short enough to be straight, in the streaks' order. Computed
/// in parallel.
/// @param time of the heads [frames since the run began]
[[nodiscard]] std::vector<StreakPiece> piecesOf(const std::vector<Streak>& streaks, const StreakShape& shape,
                                                double time);

} // namespace vdblic
