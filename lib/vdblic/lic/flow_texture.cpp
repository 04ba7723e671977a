#include "vdblic/lic/flow_texture.h"

namespace vdblic {

FlowTexture::FlowTexture(const ScatterParams& scatter, const FeedbackParams& feedback, NoiseField noise)
    : mFeedback(feedback), mNoise(std::move(noise)), mScatter(scatter)
{
    feedback.validate();
}

FlowTextureStep FlowTexture::advance(const FlowStep& step)
{
    const Domain& domain = *step.start.domain;
    if (!mInput) mInput = noiseInput(domain, mNoise);

    mField.build(step.start.domain, {step.start.velocities->tree(), step.startToStep},
                 {step.end.velocities->tree(), step.endToStep});
    const LeafValues<std::int64_t> accumulator(domain, 0);
    const double slopeScale = mLastInterval > 0 ? step.interval / mLastInterval : 1;
    mLastInterval = step.interval;

    FlowTextureStep result;
    result.stats = mScatter.step(mField, *mInput, accumulator, float(slopeScale));
    result.texture = convolve(domain, accumulator, *mInput);
    mInput = feedForward(mField, result.texture, *step.end.domain, mNoise, mFeedback, mStep++);
    return result;
}

} // namespace vdblic
