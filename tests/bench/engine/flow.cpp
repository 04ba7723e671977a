#include "bench/engine/flow.h"

#include "vdblic/field/analytic_flow.h"
#include "vdblic/field/synth.h"

#include <openvdb/openvdb.h>

namespace vdblic::bench {

Flow analyticFlow(const BoxSize& size, int frames)
{
    constexpr double kDt = 1.0 / 24;
    const FlowFunction function = flowInBox(findAnalyticFlow("abc"), size, 1.0);
    const auto domain = boxDomain(size);
    const auto transform = openvdb::math::Transform::createLinearTransform(1.0);
    Flow flow{{}, kDt};
    for (int k = 0; k < frames; ++k)
        flow.frames.push_back({FrameDomain(domain), sampleFlow(function, *domain, *transform, k * kDt)});
    return flow;
}

} // namespace vdblic::bench
