#include "vdblic/methods/auflic/scattered_texture.h"

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/lic/along_flow.h"
#include "vdblic/lic/hits.h"
#include "vdblic/lic/path_reach.h"
#include "vdblic/methods/auflic/feedback.h"
#include "vdblic/methods/auflic/flow_state.h"
#include "vdblic/methods/hand_over.h"
#include "vdblic/methods/state_grids.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace vdblic {
namespace {

/// AUFLIC's mean along the flow lowers contrast, which is restored before. The other methods do without both.
FeedbackParams feedbackOf(const TextureParams& params)
{
    FeedbackParams feedback = params.feedback;
    if (params.method->scatter->feedsMean) {
        constexpr float kLost = 1.08f;
        feedback.deviation *= kLost;
    } else {
        feedback.taps = 0;
    }
    return feedback;
}

/// @param hits the 512 Hits words of a leaf  @param counts of the values in each
void countValues(const std::int64_t* hits, std::uint64_t weight, std::int32_t* counts)
{
    for (int i = 0; i < LeafVoxel::kCount; ++i)
        counts[i] = Hits::values(std::uint64_t(hits[i]), weight);
}

} // namespace

ScatteredTexture::ScatteredTexture(const TextureParams& params, NoiseField noise)
    : mParams(params), mNoise(std::move(noise)), mScatter(params)
{
    mParams.feedback = feedbackOf(params);
}

/// The pipeline of UFLIC: Liu & Moorhead 2004, Figure 1a.
TextureFrame ScatteredTexture::advance(const FlowStep& step)
{
    TextureFrame result(step);
    StageClock clock;
    const Domain& domain = *step.start.domain.texture;
    if (!mInput) mInput = noiseInput(domain, mNoise);
    VelocityField field;
    Convolution convolution(domain, *mInput, mParams.substeps, std::move(mMean));
    {
        const auto stage = clock.enter(&StageTimes::load);
        field.prepare(step.start.domain, step.startVelocities(), step.endVelocities());
    }
    {
        const auto stage = clock.enter(&StageTimes::scatter);
        if (step.withHits) result.hits = LeafValues<std::int32_t>(domain, 0, domain.own());
        const auto take = [&](std::size_t leaf, const std::int64_t* hits) {
            convolution.take(leaf, hits);
            if (step.withHits) countValues(hits, mScatter.method().weight, result.hits[leaf]);
        };
        result.stats = mScatter.step(field, *mInput, take, *step.end.domain.texture, slopeScale(step.seconds()),
                                     step.owners, clock);
    }
    {
        const auto stage = clock.enter(&StageTimes::convolve);
        mInput.reset(); // frees memory for the next stages
        result.texture = convolution.texture();
        step.owners.takeHalo(result.texture, mParams.feedback.taps > 0 ? 1 : 0); // the reach of the mean
        result.texture =
            meanAlongFlow(domain, step.start.domain.refinement, field.start(), result.texture, mParams.feedback.taps);
        step.owners.takeHalo(result.texture);
    }
    {
        const auto stage = clock.enter(&StageTimes::filter);
        mInput = feedForward(field, result.texture, *step.end.domain.texture, mNoise, mParams.feedback, mStep,
                             mParams.substeps);
        mMean = convolution.meanOn(*step.end.domain.texture, *mInput);
    }
    result.times = clock.times();
    mDomain = step.end.domain.texture;
    mLastSeconds = step.seconds();
    ++mStep;
    return result;
}

float ScatteredTexture::slopeScale(double seconds) const
{
    return mLastSeconds > 0 ? float(seconds / mLastSeconds) : 1;
}

Lengths<Space::kTexture> ScatteredTexture::farthestPath(const Speeds<Space::kTexture, Per::kFrame>& fastest,
                                                        double seconds) const
{
    Lengths<Space::kTexture> farthest;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        float slope = fastest[axis] / float(mParams.substeps);
        for (const ParticleBins& bins : mScatter.particles())
            slope = std::max(slope, bins.largestSlope()[axis] * slopeScale(seconds));
        farthest.along[axis] = longestPath(slope);
    }
    return farthest;
}

void ScatteredTexture::handOver(const LeafOwners& owners, std::shared_ptr<const Domain> domain)
{
    mScatter.handOver(owners, *domain);
    mInput = handedOver(owners, *mDomain, *domain, *mInput);
    if (mMean) {
        mMean->mean = handedOver(owners, *mDomain, *domain, mMean->mean);
        mMean->weight = handedOver(owners, *mDomain, *domain, mMean->weight);
    }
    mDomain = std::move(domain);
}

std::size_t ScatteredTexture::parts() const
{
    return statePartCount(*mDomain);
}

TextureMemory::Saved ScatteredTexture::save(std::size_t part) const
{
    const Domain::Leaves leaves = statePart(*mDomain, part);
    Saved saved{{inputGrid(*mDomain, leaves, *mInput)}, boxOf(*mDomain, leaves)};
    if (mMean) {
        const openvdb::GridPtrVec mean = meanGrids(*mDomain, leaves, *mMean);
        saved.grids.insert(saved.grids.end(), mean.begin(), mean.end());
    }
    saved.grids.push_back(particleGrid(*mDomain, leaves, mScatter.particles()));
    return saved;
}

void ScatteredTexture::restore(std::uint64_t steps, double seconds, std::shared_ptr<const Domain> domain,
                               const std::function<std::optional<VdbFile>()>& next)
{
    mStep = steps;
    mLastSeconds = seconds;
    FlowStateReader reader(*domain, mScatter.method().words(mParams), mParams.substeps > 1);
    while (const std::optional<VdbFile> file = next())
        reader.add(*file);
    FlowState state = reader.finish();
    mInput = std::move(state.input);
    mMean = std::move(state.mean);
    mScatter.restore(steps, std::move(state.particles));
    mDomain = std::move(domain);
}

} // namespace vdblic
