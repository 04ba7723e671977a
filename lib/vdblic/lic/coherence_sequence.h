#pragma once

#include "vdblic/core/reporter.h"
#include "vdblic/lic/coherence_figures.h"
#include "vdblic/lic/coherence_params.h"
#include "vdblic/lic/estimate.h"

#include <array>
#include <vector>

namespace vdblic {

/// Means over frames of the figures of one texture, raw or smoothed.
struct MeanFigures {
    std::array<Estimate, kNamedFigures.size()> figures; ///< in the order of kNamedFigures
    std::array<double, kLagCount> along, across;
};

struct SequenceCoherence {
    std::vector<FrameCoherence> frames;
    MeanFigures raw, smoothed;
};

/// Measure every frame of a texture sequence, and report each one as soon as its figures are known.
///
/// The successor of a frame is the next one selected; the last frame has no successor and no temporal figures.
/// @throws ParameterError; InputError if the velocity or the texture of a frame is missing or their transforms differ;
///         OutputError
SequenceCoherence coherenceOfSequence(const SequenceCoherenceParams& params, Reporter& reporter);

} // namespace vdblic
