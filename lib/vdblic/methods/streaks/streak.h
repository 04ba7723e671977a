#pragma once

#include "vdblic/field/mix_bits.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace vdblic {

/// A node of a streak's pathline. Between two nodes the path is a cubic Hermite curve.
struct StreakNode {
    std::array<float, 3> position; ///< index space of the velocity, voxel centres at integers
    std::array<float, 3> slope;    ///< velocity there [voxels of the velocity a frame]
    double time;                   ///< frames since the run began
};

/// A point of the path between two nodes. @param share of their time difference, 0 to 1
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

/// A particle that lives for many frames, and the recent part of its pathline.
struct Streak {
    static constexpr double kNever = std::numeric_limits<double>::infinity();

    std::uint64_t name;             ///< hash of place and time of its release
    double born;                    ///< time of its release or entry into the domain
    double retired = kNever;        ///< time of its retirement by the controller, after which it fades
    bool slidIn = false;            ///< whether it came into sight over a rim; others fade in
    bool isStopped = false;         ///< whether its path ended at a rim or a solid, at the last node
    std::uint8_t source = 0;        ///< number of the source that it was last in; 0 for none
    std::vector<StreakNode> path{}; ///< oldest node first; never empty

    /// Whether the controller counts it: it moves and is not retired.
    [[nodiscard]] bool isLive() const { return !isStopped && retired == kNever; }

    /// The brightness of its head at a time, 0 to 1.
    [[nodiscard]] double brightness(double time) const
    {
        constexpr double kLeast = 0.6; // variation makes neighbours distinguishable
        const double own = kLeast + (1 - kLeast) * double(mixBits(name + 1) >> 11) * 0x1p-53;
        const double in = slidIn ? 1 : std::clamp((time - born) / kFade, 0.0, 1.0);
        return own * in * std::clamp(1 - (time - retired) / kFade, 0.0, 1.0);
    }
    /// The time of its tail's end at a time of the run. A young streak's tail grows from its place of release.
    /// @param tail length [frames]
    [[nodiscard]] double tailEnd(double time, double tail) const
    {
        return slidIn ? time - tail : std::max(time - tail, born);
    }
    /// Whether it is invisible from a time on. @param tail length [frames]
    [[nodiscard]] bool isGone(double time, double tail) const
    {
        return time - retired >= kFade || (isStopped && time - path.back().time >= tail);
    }

    static constexpr double kFade = 1.5; ///< duration of fading in or out [frames]
};

} // namespace vdblic
