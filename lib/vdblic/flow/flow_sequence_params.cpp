#include "vdblic/flow/flow_sequence_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

namespace vdblic {

void FlowSequenceParams::validate() const
{
    velocity.validate();
    domain.validate();
    constexpr double kLeast = 1e-18, kMost = 1e18;
    if (frameSpacing && !(*frameSpacing >= kLeast && *frameSpacing <= kMost)) {
        throw ParameterError(
            fmt::format("the frame spacing of {} s must be above 0, {} to {}", *frameSpacing, kLeast, kMost));
    }
}

} // namespace vdblic
