#pragma once

#include "vdblic/io/sequence.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <optional>
#include <vector>

namespace vdblic {

struct RenderPlan;

/// A time that has a picture: a frame's, or one between two frames.
struct Moment {
    FrameFile file;                   ///< the frame at this time, or before it
    std::optional<FrameFile> next{};  ///< the frame after it, if the time lies between two
    double share = 0;                 ///< of the way between them
    int substeps = 1;                 ///< moments in an interval between frames
    std::int64_t number = file.frame; ///< of the picture

    /// Frames that the time lies after `file`.
    [[nodiscard]] double after() const { return next ? share * double(next->frame - file.frame) : 0; }
};

/// The moments that a plan selects from a pattern or a file.
/// @throws InputError naming the missing frame, ParameterError as selectFrames()
[[nodiscard]] std::vector<Moment> momentsOf(const RenderPlan& plan);

/// The moments of a run, one by one. @param lines, count, errors as of openSequence()
[[nodiscard]] std::function<std::optional<Moment>()> openMoments(const RenderPlan& plan, std::istream& lines,
                                                                 std::size_t& count);

} // namespace vdblic
