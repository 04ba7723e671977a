#include "vdblic/flow/frame_interval.h"

namespace vdblic {

std::optional<FrameInterval> frameInterval(std::optional<double> given, const FrameTimes& current,
                                           const FrameTimes* next, double skipped)
{
    constexpr double kLeast = 1e-18, kMost = 1e18; // the limits of `frame_spacing`
    const auto isTime = [](double seconds) { return seconds >= kLeast && seconds <= kMost; };
    if (given) return FrameInterval{*given * skipped, "as given"};
    if (next && current.time && next->time) {
        const double seconds = *next->time - *current.time;
        if (isTime(seconds)) return FrameInterval{seconds, "by the files' times"};
        return std::nullopt;
    }
    if (current.dt && isTime(*current.dt)) return FrameInterval{*current.dt * skipped, "by the files' dt"};
    constexpr double kDefaultFps = 24;
    return FrameInterval{skipped / kDefaultFps, "24 frames a second", true};
}

} // namespace vdblic
