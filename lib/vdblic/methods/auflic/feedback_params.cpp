#include "vdblic/methods/auflic/feedback_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

namespace vdblic {

Parameters parametersOf(FeedbackParams& params)
{
    return {
        parameter("sharpen", "Strength of the high-pass filter between steps.", params.sharpen, {.limits = {0, 100}}),
        parameter("noise_share", "Share of the original noise in the input of a step.", params.noiseShare,
                  {.limits = {0, 1}}),
    };
}

void FeedbackParams::validate() const
{
    FeedbackParams copy = *this;
    checkLimits(parametersOf(copy));
    if (!(deviation > 0 && deviation <= 0.5f)) {
        throw ParameterError(fmt::format("deviation {} must be above 0 and at most 0.5", deviation));
    }
}

} // namespace vdblic
