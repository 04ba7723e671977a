#include "vdblic/flow/velocity_sequence_params.h"

#include "vdblic/core/errors.h"

namespace vdblic {

Parameters parametersOf(VelocitySequenceParams& params)
{
    constexpr double kLeast = 1e-18, kMost = 1e18;
    Parameters all = parametersOf(params.velocity);
    all.push_back(parameter("frame_spacing",
                            "Seconds between the frames on disk; from the files' metadata by default, else 1/24.",
                            params.frameSpacing, {.option = "--dt", .unit = "s", .limits = {kLeast, kMost}}));
    const auto setFps = [&params](const Words& words) { params.frameSpacing = 1 / detail::numberIn(words[0]).value(); };
    all.push_back(parameter("fps", "Frames per second, instead of the seconds between them.", WordType::kNumber, 1,
                            setFps, [] { return Words{}; },
                            {.limits = {1 / kMost, 1 / kLeast}, .excludes = "frame_spacing"}));
    return all;
}

void VelocitySequenceParams::validate() const
{
    velocity.validate();
    domain.validate();
    observer.validate();
    if (!domain.periodic.empty() && !observer.isAtRest()) {
        throw ParameterError(
            "`periodic` and an observer who moves exclude each other: the observer's box would leave the "
            "period; leave one out");
    }
    VelocitySequenceParams copy = *this;
    checkLimits(parametersOf(copy));
}

} // namespace vdblic
