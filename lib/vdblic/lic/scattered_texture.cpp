#include "vdblic/lic/scattered_texture.h"

#include "vdblic/lic/along_flow.h"
#include "vdblic/lic/feedback.h"
#include "vdblic/lic/flow_state.h"
#include "vdblic/lic/path_reach.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

/// A mean along the flow is AUFLIC's; it takes contrast away, which is restored before. The others do without.
FeedbackParams feedbackOf(const TextureParams& params)
{
    FeedbackParams feedback = params.feedback;
    if (params.method == TextureMethod::kAuflic) {
        constexpr float kLost = 1.08f;
        feedback.deviation *= kLost;
    } else {
        feedback.taps = 0;
    }
    return feedback;
}

/// Values on own leaves, handed over to the ranks that own the leaves in another partition. Collective.
/// @param from, to the same domain before and in that partition
template<typename T>
LeafValues<T> handedOver(const LeafOwners& owners, const Domain& from, const Domain& to, const LeafValues<T>& values)
{
    LeafValues<T> result(to, T(0), to.own());
    for (const std::uint32_t leaf : from.own()) {
        if (to.isOwn(leaf)) std::copy_n(values[leaf], LeafVoxel::kCount, result[leaf]);
    }
    owners.send(
        to,
        [&](std::size_t leaf, Exchange::Bytes& message) {
            if (from.isOwn(leaf)) put(message, values[leaf], LeafVoxel::kCount);
        },
        [&](std::size_t leaf, MessageReader& message) { message.get(result[leaf], LeafVoxel::kCount); });
    return result;
}

} // namespace

ScatteredTexture::ScatteredTexture(const TextureParams& params, NoiseField noise)
    : mParams(params), mNoise(std::move(noise)), mScatter(params)
{
    mParams.feedback = feedbackOf(params);
}

/// The pipeline of UFLIC: Liu & Moorhead 2004, Figure 1a.
FlowTextureStep ScatteredTexture::advance(const FlowStep& step)
{
    FlowTextureStep result;
    StageClock clock;
    const Domain& domain = *step.start.domain;
    if (!mInput) mInput = noiseInput(domain, mNoise);
    VelocityField field;
    Convolution convolution(domain, *mInput, mParams.substeps, std::move(mMean));
    {
        const auto stage = clock.enter(&StageTimes::load);
        field.prepare(step.start.fieldDomain(), {step.start.velocities->tree(), step.startToStep},
                      {step.end.velocities->tree(), step.endToStep});
    }
    {
        const auto stage = clock.enter(&StageTimes::scatter);
        result.stats = mScatter.step(
            field, *mInput, [&](std::size_t leaf, const std::int64_t* hits) { convolution.take(leaf, hits); },
            *step.end.domain, slopeScale(step.interval), step.owners, clock);
    }
    {
        const auto stage = clock.enter(&StageTimes::convolve);
        mInput.reset(); // makes room for what follows
        result.texture = convolution.texture();
        step.owners.takeHalo(result.texture, mParams.feedback.taps > 0 ? 1 : 0); // as far as the mean reaches
        result.texture =
            meanAlongFlow(domain, step.start.refinement, field.start(), result.texture, mParams.feedback.taps);
        step.owners.takeHalo(result.texture);
    }
    {
        const auto stage = clock.enter(&StageTimes::filter);
        mInput =
            feedForward(field, result.texture, *step.end.domain, mNoise, mParams.feedback, mStep, mParams.substeps);
        mMean = convolution.meanOn(*step.end.domain, *mInput);
    }
    result.times = clock.times();
    result.domain = step.start.domain;
    result.refinement = step.start.refinement;
    mDomain = step.end.domain;
    mLastInterval = step.interval;
    ++mStep;
    return result;
}

float ScatteredTexture::slopeScale(double interval) const
{
    return mLastInterval > 0 ? float(interval / mLastInterval) : 1;
}

std::array<float, 3> ScatteredTexture::farthestPath(const std::array<float, 3>& displacement, double interval) const
{
    std::array<float, 3> farthest{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        float slope = displacement[axis] / float(mParams.substeps);
        for (const ParticleBins& bins : mScatter.particles())
            slope = std::max(slope, bins.largestSlope()[axis] * slopeScale(interval));
        farthest[axis] = longestPath(slope);
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
    constexpr std::size_t kLeaves = 4096, kMost = 8;
    return std::clamp((mDomain->own().size() + kLeaves - 1) / kLeaves, std::size_t(1), kMost);
}

FlowTexture::Saved ScatteredTexture::save(std::size_t part) const
{
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

void ScatteredTexture::restore(std::uint64_t steps, double interval, std::shared_ptr<const Domain> domain,
                               const std::function<std::optional<VdbFile>()>& next)
{
    mStep = steps;
    mLastInterval = interval;
    FlowStateReader reader(*domain, mScatter.wordsOfParticles(), mParams.substeps > 1);
    while (const std::optional<VdbFile> file = next())
        reader.add(*file);
    FlowState state = reader.finish();
    mInput = std::move(state.input);
    mMean = std::move(state.mean);
    mScatter.restore(steps, std::move(state.particles));
    mDomain = std::move(domain);
}

} // namespace vdblic
