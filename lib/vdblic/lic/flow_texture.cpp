#include "vdblic/lic/flow_texture.h"

#include "vdblic/core/stopwatch.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/lic/along_flow.h"
#include "vdblic/lic/convolve.h"
#include "vdblic/lic/feedback.h"
#include "vdblic/lic/flow_state.h"
#include "vdblic/lic/scatter.h"
#include "vdblic/lic/steady_lic.h"

#include <cstddef>
#include <utility>

namespace vdblic {

StageTimes& StageTimes::operator+=(const StageTimes& other)
{
    load += other.load;
    scatter += other.scatter;
    convolve += other.convolve;
    filter += other.filter;
    return *this;
}

class FlowTexture::Pipeline {
  public:
    Pipeline(const ScatterParams& scatter, const FeedbackParams& feedback, NoiseField noise,
             std::optional<LicKernel> steady)
        : mParams(scatter), mFeedback(feedback), mNoise(std::move(noise)), mSteady(steady), mScatter(scatter)
    {
        feedback.validate();
    }

    FlowTextureStep advance(const FlowStep& step)
    {
        FlowTextureStep result = mSteady ? convolveFrame(step) : scatterStep(step);
        ++mStep;
        return result;
    }

    [[nodiscard]] std::uint64_t steps() const { return mStep; }

    [[nodiscard]] openvdb::GridPtrVec save() const
    {
        if (mSteady) return {};
        openvdb::GridPtrVec grids{inputGrid(*mDomain, *mInput)};
        if (mMean) {
            const openvdb::GridPtrVec mean = meanGrids(*mMean);
            grids.insert(grids.end(), mean.begin(), mean.end());
        }
        grids.push_back(particleGrid(*mDomain, mScatter.particles()));
        return grids;
    }

    void restore(std::uint64_t steps, double interval, std::shared_ptr<const Domain> domain, const VdbFile& state)
    {
        mStep = steps;
        if (mSteady) return;
        mLastInterval = interval;
        mInput = readInput(*domain, state);
        if (mParams.substeps > 1) mMean = readMean(*domain, state);
        mScatter.restore(steps, readParticles(*domain, state, mParams.generations()));
        mDomain = std::move(domain);
    }

  private:
    FlowTextureStep convolveFrame(const FlowStep& step) const
    {
        Stopwatch watch;
        FlowTextureStep result;
        result.texture = steadyLic(step.start, step.startToStep, mParams.lifeSpan * mParams.substeps, *mSteady,
                                   mParams.pathline, mNoise);
        result.times.convolve = watch.lap();
        return result;
    }

    FlowTextureStep scatterStep(const FlowStep& step)
    {
        Stopwatch watch;
        FlowTextureStep result;
        const Domain& domain = *step.start.domain;
        if (!mInput) mInput = noiseInput(domain, mNoise);
        mField.prepare(step.start.fieldDomain(), {step.start.velocities->tree(), step.startToStep},
                       {step.end.velocities->tree(), step.endToStep});
        {
            const LeafValues<std::int64_t> accumulator = makeAccumulator(domain);
            const double slopeScale = mLastInterval > 0 ? step.interval / mLastInterval : 1;
            mLastInterval = step.interval;
            result.stats = mScatter.step(mField, *mInput, accumulator, *step.end.domain, float(slopeScale));
            result.times.load = mField.secondsToFill();
            result.times.scatter = watch.lap() - result.times.load;

            if (mParams.substeps == 1) {
                result.texture = convolve(domain, accumulator, *mInput);
            } else {
                mMean = convolve(domain, accumulator, *mInput, mMean ? &*mMean : nullptr, mParams.substeps);
                result.texture = mMean->mean;
            }
        } // the accumulator and the input make room for what follows
        mInput.reset();
        if (mParams.method == ScatterMethod::kAuflic) {
            result.texture =
                meanAlongFlow(domain, step.start.refinement, mField.start(), result.texture, mFeedback.taps);
        }
        result.times.convolve = watch.lap();
        mInput = feedForward(mField, result.texture, *step.end.domain, mNoise, mFeedback, mStep, mParams.substeps);
        if (mMean && step.end.domain != step.start.domain) mMean = onDomain(*step.end.domain, *mInput, domain, *mMean);
        result.times.filter = watch.lap();
        mDomain = step.end.domain;
        return result;
    }

    ScatterParams mParams;
    FeedbackParams mFeedback;
    NoiseField mNoise;
    std::optional<LicKernel> mSteady;
    Scatter mScatter;
    VelocityField mField;
    std::shared_ptr<const Domain> mDomain; // of the step to come
    std::optional<LeafValues<std::int32_t>> mInput;
    std::optional<RunningMean> mMean; // with substeps
    double mLastInterval = 0;
    std::uint64_t mStep = 0;
};

FlowTexture::FlowTexture(const ScatterParams& scatter, const FeedbackParams& feedback, NoiseField noise,
                         std::optional<LicKernel> steady)
    : mPipeline(std::make_unique<Pipeline>(scatter, feedback, std::move(noise), steady))
{
}
FlowTexture::~FlowTexture() = default;
FlowTexture::FlowTexture(FlowTexture&&) noexcept = default;
FlowTexture& FlowTexture::operator=(FlowTexture&&) noexcept = default;

FlowTextureStep FlowTexture::advance(const FlowStep& step)
{
    return mPipeline->advance(step);
}

std::uint64_t FlowTexture::steps() const
{
    return mPipeline->steps();
}

openvdb::GridPtrVec FlowTexture::save() const
{
    return mPipeline->save();
}

void FlowTexture::restore(std::uint64_t steps, double interval, std::shared_ptr<const Domain> domain,
                          const VdbFile& state)
{
    mPipeline->restore(steps, interval, std::move(domain), state);
}

} // namespace vdblic
