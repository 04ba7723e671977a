#pragma once

#include "vdblic/coherence/coherence_sequence.h"

#include <string>
#include <vector>

namespace vdblic {

/// Headings of the columns of frameLine().
[[nodiscard]] std::string frameHeading();
/// The main figures of a frame in one line, raw | smoothed.
[[nodiscard]] std::string frameLine(const FrameCoherence& frame);
/// Every mean with its confidence interval, line by line.
[[nodiscard]] std::vector<std::string> meanLines(const SequenceCoherence& coherence);

/// The means by class of displacement, line by line.
[[nodiscard]] std::vector<std::string> displacementLines(const SequenceCoherence& coherence);

/// The same of sparse textures.
[[nodiscard]] std::string sparseHeading();
[[nodiscard]] std::string sparseLine(const SparseCoherence& frame);
[[nodiscard]] std::vector<std::string> sparseMeanLines(const SequenceCoherence& coherence);

/// Everything that was measured, as JSON with two spaces of indentation (docs/measure.md); unknown figures are null.
[[nodiscard]] std::string toJson(const SequenceCoherence& coherence, const SequenceCoherenceParams& params);

} // namespace vdblic
