#include "bench/engine/coherence_meter.h"

#include "vdblic/coherence/coherence.h"

#include <cstdint>
#include <utility>

namespace vdblic::bench {

void CoherenceMeter::add(const Flow& flow, std::size_t k, const LeafValues<float>& texture, Figures& figures)
{
    SmoothedTexture current(*texture.tree());
    if (mLast) {
        CoherenceParams params;
        params.samples = 30'000;
        VelocityField field;
        flow.build(k - 1, field);
        const FrameCoherence c = measureCoherence(*mLast, &current, field, params, std::int64_t(k));
        figures.temporal.push_back(c.raw.temporal);
        figures.smoothed.push_back(c.smoothed.temporal);
        figures.along.push_back(c.raw.alongLength);
        figures.deviation.push_back(c.raw.deviation);
    }
    mLast.emplace(std::move(current));
}

} // namespace vdblic::bench
