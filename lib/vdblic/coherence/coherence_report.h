#pragma once

#include "vdblic/coherence/coherence_sequence.h"

#include <string>
#include <vector>

namespace vdblic {

/// Headings of the columns of frameLine().
[[nodiscard]] std::string frameHeading();
/// The main figures of a frame in one line, raw | smoothed.
[[nodiscard]] std::string frameLine(const FrameCoherence& frame);
/// Lines of text: every mean with its confidence interval.
[[nodiscard]] std::vector<std::string> meanLines(const SequenceCoherence& coherence);

/// Lines of text: the means by class of displacement.
[[nodiscard]] std::vector<std::string> displacementLines(const SequenceCoherence& coherence);

/// The same of sparse textures.
[[nodiscard]] std::string sparseHeading();
[[nodiscard]] std::string sparseLine(const SparseCoherence& frame);
[[nodiscard]] std::vector<std::string> sparseMeanLines(const SequenceCoherence& coherence);

/// All figures as JSON with two spaces of indentation (docs/measure.md); unknown figures are null.
[[nodiscard]] std::string toJson(const SequenceCoherence& coherence, const SequenceCoherenceParams& params);

} // namespace vdblic
