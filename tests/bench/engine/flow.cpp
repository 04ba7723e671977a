#include "bench/engine/flow.h"

#include "vdblic/core/exchange.h"
#include "vdblic/core/reporter.h"
#include "vdblic/field/analytic_flow.h"
#include "vdblic/field/synth.h"
#include "vdblic/flow/flow_sequence.h"

#include <optional>
#include <sstream>
#include <utility>

namespace vdblic::bench {

Flow analyticFlow(const BoxSize& size, int frames, const std::shared_ptr<const Domain>& domain)
{
    constexpr double kDt = 1.0 / 24;
    const FlowFunction function = flowInBox(findAnalyticFlow("abc"), size, 1.0);
    const auto transform = openvdb::math::Transform::createLinearTransform(1.0);
    Flow flow;
    for (int k = 0; k < frames; ++k) {
        flow.frames.push_back({domain, sampleFlow(function, *domain, *transform, k * kDt)});
        flow.toStep.push_back(openvdb::Mat3d::identity() * kDt);
    }
    return flow;
}

Flow flowOfFiles(const std::string& pattern, const std::string& range)
{
    FlowSequenceParams params;
    params.input.pattern = pattern;
    params.input.frames = range;
    Reporter silent;
    std::istringstream noLines;
    const OneProcess alone;
    std::size_t total = 0;
    FlowSequence sequence(params, openSequence(params.input, noLines, total), silent, alone);
    Flow flow;
    std::optional<LoadedFrame> frame = sequence.next();
    while (frame) {
        std::optional<LoadedFrame> next = sequence.next();
        const double seconds = sequence.intervalAfter(*frame, next ? &*next : nullptr).seconds;
        flow.toStep.push_back(frame->velocity.toVoxelsPerStep(seconds));
        flow.frames.push_back(frame->flow());
        frame = std::move(next);
    }
    return flow;
}

} // namespace vdblic::bench
