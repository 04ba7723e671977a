#pragma once

#include "vdblic/lic/coherence.h"

#include <string>
#include <vector>

namespace vdblic {

/// The columns of frameLine().
[[nodiscard]] std::string frameHeading();
/// The main figures of a frame in one line, raw | smoothed.
[[nodiscard]] std::string frameLine(const FrameCoherence& frame);
/// Every mean with its confidence interval, line by line.
[[nodiscard]] std::vector<std::string> meanLines(const SequenceCoherence& coherence);

/// Everything that was measured, as JSON with two spaces of indentation (docs/quality.md); what could not be had is
/// null.
[[nodiscard]] std::string toJson(const SequenceCoherence& coherence, const SequenceCoherenceParams& params);

/// The mean autocorrelations by lag, along and across the flow, raw and smoothed, as an SVG image.
[[nodiscard]] std::string toSvg(const SequenceCoherence& coherence);

} // namespace vdblic
