#pragma once

#include "vdblic/methods/flow_texture.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdblic {

/// The work and the time of one frame of a run. Reading and writing overlap with the computation of other frames.
struct FrameReport {
    std::int64_t frame = 0;
    std::size_t voxels = 0;
    ScatterStats stats;
    double read = 0; ///< seconds to read the velocity
    StageTimes times;
    double write = 0; ///< seconds to write the texture
};

/// The computed frames of a run.
struct RunReport {
    std::vector<FrameReport> frames;
    double seconds = 0; ///< wall time from the first step to the last output
};

/// A line about a frame's work.
[[nodiscard]] std::string frameLine(const FrameReport& frame);

/// The time of a run by stage, as in Table 2 of Liu & Moorhead 2004, and its spread over the frames.
[[nodiscard]] std::vector<std::string> runLines(const RunReport& report);

/// All figures, as JSON with two spaces of indentation (docs/advect.md).
[[nodiscard]] std::string toJson(const RunReport& report);

} // namespace vdblic
