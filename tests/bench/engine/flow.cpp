#include "bench/engine/flow.h"

#include "vdblic/core/exchange.h"
#include "vdblic/core/reporter.h"
#include "vdblic/field/analytic_flow.h"
#include "vdblic/field/synth.h"
#include "vdblic/flow/velocity_sequence.h"

#include <optional>
#include <sstream>
#include <utility>

namespace vdblic::bench {

Flow analyticFlow(const BoxSize& size, int frames, const std::shared_ptr<const Domain>& domain)
{
    constexpr double kDt = 1.0 / 24;
    const FlowFunction function = flowInBox(findAnalyticFlow("abc"), size, 1.0);
    const auto transform = openvdb::math::Transform::createLinearTransform(1.0);
    Flow flow{{}, kDt};
    for (int k = 0; k < frames; ++k)
        flow.frames.push_back({FrameDomain(domain), sampleFlow(function, *domain, *transform, k * kDt)});
    return flow;
}

Flow flowOfFiles(const std::string& pattern, const std::string& range)
{
    VelocitySequenceParams params;
    params.input.pattern = pattern;
    params.input.frames = range;
    Reporter silent;
    std::istringstream noLines;
    OneProcess alone;
    std::size_t total = 0;
    VelocitySequence sequence(params, openSequence(params.input, noLines, total), silent, alone);
    Flow flow;
    std::optional<VelocityFrame> frame = sequence.next();
    while (frame) {
        std::optional<VelocityFrame> next = sequence.next();
        if (next) flow.interval = sequence.intervalAfter(*frame, &*next).seconds;
        flow.frames.push_back(*frame);
        frame = std::move(next);
    }
    return flow;
}

} // namespace vdblic::bench
