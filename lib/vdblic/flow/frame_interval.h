#pragma once

#include "vdblic/flow/velocity_frame.h"

#include <optional>

namespace vdblic {

/// Time between two frames [s] and its source, for messages.
struct FrameInterval {
    double seconds;
    const char* source;
    bool isAssumed = false; ///< whether neither parameters nor files give it
};

/// The time from a frame to the next: as given, else by the frames' times, else by the first one's dt, else 1/24 s.
/// @param given   seconds between neighbours on disk; nothing: not given
/// @param next    times of the frame after it; null if there is none
/// @param skipped intervals between neighbours on disk from the one frame to the other
/// @return nothing if the frames' times do not ascend
[[nodiscard]] std::optional<FrameInterval> frameInterval(std::optional<double> given, const FrameTimes& current,
                                                         const FrameTimes* next, double skipped);

} // namespace vdblic
