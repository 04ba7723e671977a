#pragma once

#include "vdblic/core/parameters.h"

namespace vdblic {

/// The noise-jittered high-pass filter between a texture and the next step's input.
struct FeedbackParams {
    int taps = 2;            ///< AUFLIC: samples to each side in the mean along the flow before the filter
    float sharpen = 1;       ///< strength s of c + s (c − mean of the 26 neighbours)
    float noiseShare = 0.1f; ///< share of the original noise, 0 to 1
    float deviation = 0.25f; ///< standard deviation to which local contrast is restored; uniform noise has 0.289

    void validate() const; ///< @throws ParameterError
};
[[nodiscard]] Parameters parametersOf(FeedbackParams& params);

} // namespace vdblic
