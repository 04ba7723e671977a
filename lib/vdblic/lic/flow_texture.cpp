#include "vdblic/lic/flow_texture.h"

#include "vdblic/core/stopwatch.h"
#include "vdblic/lic/flow_state.h"

namespace vdblic {

StageTimes& StageTimes::operator+=(const StageTimes& other)
{
    load += other.load;
    scatter += other.scatter;
    convolve += other.convolve;
    filter += other.filter;
    return *this;
}

FlowTexture::FlowTexture(const ScatterParams& scatter, const FeedbackParams& feedback, NoiseField noise,
                         std::optional<LicKernel> steady)
    : mParams(scatter), mFeedback(feedback), mNoise(std::move(noise)), mSteady(steady), mScatter(scatter)
{
    feedback.validate();
}

FlowTextureStep FlowTexture::advance(const FlowStep& step)
{
    Stopwatch watch;
    FlowTextureStep result;
    if (mSteady) {
        result.texture = steadyLic(step.start, step.startToStep, mParams.lifeSpan, *mSteady, mParams.pathline, mNoise);
        result.times.convolve = watch.lap();
        ++mStep;
        return result;
    }
    const Domain& domain = *step.start.domain;
    if (!mInput) mInput = noiseInput(domain, mNoise);
    mField.prepare(step.start.domain, {step.start.velocities->tree(), step.startToStep},
                   {step.end.velocities->tree(), step.endToStep});
    {
        const LeafValues<std::int64_t> accumulator = makeAccumulator(domain);
        const double slopeScale = mLastInterval > 0 ? step.interval / mLastInterval : 1;
        mLastInterval = step.interval;
        result.stats = mScatter.step(mField, *mInput, accumulator, *step.end.domain, float(slopeScale));
        result.times.load = mField.secondsToFill();
        result.times.scatter = watch.lap() - result.times.load;

        result.texture = convolve(domain, accumulator, *mInput);
        result.times.convolve = watch.lap();
    }
    mInput.reset(); // before its successor is made
    mInput = feedForward(mField, result.texture, *step.end.domain, mNoise, mFeedback, mStep);
    result.times.filter = watch.lap();
    mDomain = step.end.domain;
    ++mStep;
    return result;
}

openvdb::GridPtrVec FlowTexture::save() const
{
    if (mSteady) return {};
    openvdb::GridPtrVec grids = inputGrids(*mDomain, *mInput);
    grids.push_back(particleGrid(*mDomain, mScatter.particles()));
    return grids;
}

void FlowTexture::restore(std::uint64_t steps, double interval, std::shared_ptr<const Domain> domain,
                          const VdbFile& state)
{
    mStep = steps;
    if (mSteady) return;
    mLastInterval = interval;
    mInput = readInput(*domain, state);
    const bool carries = mParams.method == ScatterMethod::kAuflic;
    mScatter.restore(steps, readParticles(*domain, state, carries ? std::size_t(mParams.lifeSpan) : 0));
    mDomain = std::move(domain);
}

} // namespace vdblic
