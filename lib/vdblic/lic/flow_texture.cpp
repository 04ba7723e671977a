#include "vdblic/lic/flow_texture.h"

#include "vdblic/core/stopwatch.h"
#include "vdblic/distributed/leaf_move.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/along_flow.h"
#include "vdblic/lic/convolve.h"
#include "vdblic/lic/feedback.h"
#include "vdblic/lic/flow_state.h"
#include "vdblic/lic/scatter.h"
#include "vdblic/lic/steady_lic.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
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
        : mParams(scatter), mFeedback(scatter.method == ScatterMethod::kAuflic ? feedback.beforeMean() : feedback),
          mNoise(std::move(noise)), mSteady(steady), mScatter(scatter)
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

    [[nodiscard]] std::size_t parts() const
    {
        constexpr std::size_t kLeaves = 4096, kMost = 8;
        return mSteady ? 1 : std::clamp((mDomain->own().size() + kLeaves - 1) / kLeaves, std::size_t(1), kMost);
    }

    [[nodiscard]] Saved save(std::size_t part) const
    {
        if (mSteady) return {};
        const Domain::Leaves own = mDomain->own();
        const std::size_t begin = own.size() * part / parts(), end = own.size() * (part + 1) / parts();
        const Domain::Leaves leaves = own.subspan(begin, end - begin);
        Saved saved{{inputGrid(*mDomain, leaves, *mInput)}, {}};
        if (mMean) {
            const openvdb::GridPtrVec mean = meanGrids(*mDomain, leaves, *mMean);
            saved.grids.insert(saved.grids.end(), mean.begin(), mean.end());
        }
        saved.grids.push_back(particleGrid(*mDomain, leaves, mScatter.particles()));
        for (const std::uint32_t leaf : leaves)
            saved.box.expand(mDomain->origin(leaf), LeafVoxel::kDim);
        return saved;
    }

    [[nodiscard]] std::array<float, 3> largestSlope(double interval) const
    {
        std::array<float, 3> largest{};
        for (const ParticleBins& bins : mScatter.particles()) {
            for (std::size_t axis = 0; axis < 3; ++axis)
                largest[axis] = std::max(largest[axis], bins.largestSlope()[axis] * slopeScale(interval));
        }
        return largest;
    }

    void move(Exchange& exchange, const Partition& partition, std::shared_ptr<const Domain> domain)
    {
        if (mSteady) return;
        std::vector<std::uint32_t> local;
        std::set_union(mDomain->own().begin(), mDomain->own().end(), domain->own().begin(), domain->own().end(),
                       std::back_inserter(local));
        mScatter.move(exchange, partition,
                      *domain->part({domain->own().begin(), domain->own().end()}, std::move(local)));
        mInput = moved(exchange, partition, *mDomain, *domain, *mInput);
        if (mMean) {
            mMean->mean = moved(exchange, partition, *mDomain, *domain, mMean->mean);
            mMean->weight = moved(exchange, partition, *mDomain, *domain, mMean->weight);
        }
        mDomain = std::move(domain);
    }

    void restore(std::uint64_t steps, double interval, std::shared_ptr<const Domain> domain,
                 const std::function<std::optional<VdbFile>()>& next)
    {
        mStep = steps;
        if (mSteady) return;
        mLastInterval = interval;
        FlowStateReader reader(*domain, mParams.generations(), mParams.substeps > 1);
        while (const std::optional<VdbFile> file = next())
            reader.add(*file);
        FlowState state = reader.finish();
        mInput = std::move(state.input);
        mMean = std::move(state.mean);
        mScatter.restore(steps, std::move(state.particles));
        mDomain = std::move(domain);
    }

  private:
    /// Slopes are displacements in a step: of a longer step they are larger.
    [[nodiscard]] float slopeScale(double interval) const
    {
        return mLastInterval > 0 ? float(interval / mLastInterval) : 1;
    }

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
        VelocityField field;
        field.prepare(step.start.fieldDomain(), {step.start.velocities->tree(), step.startToStep},
                      {step.end.velocities->tree(), step.endToStep});
        std::optional<RunningMean> mean;
        if (mParams.substeps > 1) {
            mean = RunningMean{{domain, 0.0f, domain.own()}, {domain, 0.0f, domain.own()}};
        } else {
            result.texture = LeafValues<float>(domain, 0.0f);
        }
        const auto take = [&](std::size_t leaf, const std::int64_t* hits) {
            const Domain::Mask& mask = domain.mask(leaf);
            const std::int32_t* const input = (*mInput)[leaf];
            if (mean) {
                convolve(mask, hits, input, mParams.substeps, mMean ? mMean->of(leaf) : MeanLeaf{}, mean->of(leaf));
            } else {
                convolve(mask, hits, input, result.texture[leaf]);
            }
        };
        result.stats = mScatter.step(field, *mInput, take, *step.end.domain, slopeScale(step.interval), step.halo);
        mLastInterval = step.interval;
        result.times.load = field.secondsToFill();
        result.times.scatter = watch.lap() - result.times.load - mScatter.secondsToTake();
        if (mean) {
            mMean = std::move(mean);
            result.texture = onLocal(domain, mMean->mean);
        }
        mInput.reset(); // makes room for what follows
        if (mParams.method == ScatterMethod::kAuflic) {
            if (step.halo) step.halo->takeFromOwners(result.texture, 1); // as far as the mean reaches
            result.texture =
                meanAlongFlow(domain, step.start.refinement, field.start(), result.texture, mFeedback.taps);
        }
        if (step.halo) step.halo->takeFromOwners(result.texture);
        result.times.convolve = watch.lap() + mScatter.secondsToTake();
        mInput = feedForward(field, result.texture, *step.end.domain, mNoise, mFeedback, mStep, mParams.substeps);
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

std::array<float, 3> FlowTexture::largestSlope(double interval) const
{
    return mPipeline->largestSlope(interval);
}

std::uint64_t FlowTexture::steps() const
{
    return mPipeline->steps();
}

std::size_t FlowTexture::parts() const
{
    return mPipeline->parts();
}

FlowTexture::Saved FlowTexture::save(std::size_t part) const
{
    return mPipeline->save(part);
}

void FlowTexture::move(Exchange& exchange, const Partition& partition, std::shared_ptr<const Domain> domain)
{
    mPipeline->move(exchange, partition, std::move(domain));
}

void FlowTexture::restore(std::uint64_t steps, double interval, std::shared_ptr<const Domain> domain,
                          const std::function<std::optional<VdbFile>()>& next)
{
    mPipeline->restore(steps, interval, std::move(domain), next);
}

} // namespace vdblic
