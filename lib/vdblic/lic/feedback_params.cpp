#include "vdblic/lic/feedback_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

namespace vdblic {

void FeedbackParams::validate() const
{
    if (!(sharpen >= 0 && sharpen <= 100)) {
        throw ParameterError(fmt::format("sharpening {} must lie in 0 to 100", sharpen));
    }
    if (!(noiseShare >= 0 && noiseShare <= 1)) {
        throw ParameterError(fmt::format("noise share {} must lie in 0 to 1", noiseShare));
    }
    if (!(deviation > 0 && deviation <= 0.5f)) {
        throw ParameterError(fmt::format("deviation {} must be above 0 and at most 0.5", deviation));
    }
}

} // namespace vdblic
