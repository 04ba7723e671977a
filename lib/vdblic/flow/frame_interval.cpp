#include "vdblic/flow/frame_interval.h"

#include <cmath>

namespace vdblic {

std::optional<FrameInterval> frameInterval(std::optional<double> given, const FrameTimes& current,
                                           const FrameTimes* next, double skipped)
{
    if (given) return FrameInterval{*given * skipped, "as given"};
    if (next && current.time && next->time) {
        const double seconds = *next->time - *current.time;
        if (seconds > 0 && std::isfinite(seconds)) return FrameInterval{seconds, "by the files' times"};
        return std::nullopt;
    }
    if (current.dt && *current.dt > 0 && std::isfinite(*current.dt))
        return FrameInterval{*current.dt * skipped, "by the files' dt"};
    constexpr double kDefaultFps = 24;
    const char* const source =
        current.dt ? "24 frames a second, because the files' dt is no time" : "24 frames a second by default";
    return FrameInterval{skipped / kDefaultFps, source, true};
}

} // namespace vdblic
