#pragma once

#include "vdblic/field/mix_bits.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace vdblic {

/// A point of a streak's pathline. Between two of them the path is a cubic Hermite curve.
struct StreakNode {
    std::array<float, 3> position; ///< index space of the velocity, voxel centres at integers
    std::array<float, 3> slope;    ///< velocity there [voxels of the velocity a frame]
    double time;                   ///< frames since the run began
};

/// A point of the path between two nodes. @param share of the time between them, 0 to 1
[[nodiscard]] inline std::array<float, 3> positionBetween(const StreakNode& a, const StreakNode& b, float share)
{
    const auto duration = float(b.time - a.time);
    std::array<float, 3> position{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const float chord = b.position[axis] - a.position[axis];
        const float m0 = a.slope[axis] * duration, m1 = b.slope[axis] * duration;
        position[axis] =
            a.position[axis] + ((m0 + m1 - 2 * chord) * share + (3 * chord - 2 * m0 - m1)) * share * share + m0 * share;
    }
    return position;
}

/// A particle that lives for many frames, with the last part of its pathline.
struct Streak {
    static constexpr double kNever = std::numeric_limits<double>::infinity();

    std::uint64_t name;             ///< hash of the place and the time of its release
    double born;                    ///< when it was released, or entered the domain
    double retired = kNever;        ///< when the controller retired it; from then on it fades
    bool slidIn = false;            ///< whether it came in over a rim; the others fade in
    bool isStopped = false;         ///< whether its path ended at a rim or at a solid, at the last node
    std::uint8_t source = 0;        ///< number of the source that it last was in; 0 for none
    std::vector<StreakNode> path{}; ///< oldest node first; never empty

    /// Whether it counts for the controller: it moves, and was not retired.
    [[nodiscard]] bool isLive() const { return !isStopped && retired == kNever; }

    /// How bright its head is at a time, 0 to 1.
    [[nodiscard]] double brightness(double time) const
    {
        constexpr double kLeast = 0.6; // streaks differ, so that neighbours stand out against each other
        const double own = kLeast + (1 - kLeast) * double(mixBits(name + 1) >> 11) * 0x1p-53;
        const double in = slidIn ? 1 : std::clamp((time - born) / kFade, 0.0, 1.0);
        return own * in * std::clamp(1 - (time - retired) / kFade, 0.0, 1.0);
    }
    /// Where its tail ends at a time of the run. That of a young one grows from where it was released.
    /// @param tail in frames
    [[nodiscard]] double tailEnd(double time, double tail) const
    {
        return slidIn ? time - tail : std::max(time - tail, born);
    }
    /// Whether nothing of it can be seen from a time on. @param tail in frames
    [[nodiscard]] bool isGone(double time, double tail) const
    {
        return time - retired >= kFade || (isStopped && time - path.back().time >= tail);
    }

    static constexpr double kFade = 1.5; ///< frames that fading in and out takes
};

} // namespace vdblic
