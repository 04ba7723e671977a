#include "vdblic/methods/backward/backward_texture.h"

#include "vdblic/field/for_leaves.h"
#include "vdblic/lic/path_reach.h"
#include "vdblic/methods/hand_over.h"
#include "vdblic/methods/state_grids.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace vdblic {
namespace {

/// Values on a domain's own leaves, on all local ones. Collective.
LeafValues<float> withHalo(const Domain& domain, const LeafOwners& owners, LeafValues<float> own)
{
    if (domain.isWhole()) return own;
    LeafValues<float> local(domain, 0.0f);
    forLeaves(domain.own(), [&](std::size_t leaf) { std::copy_n(own[leaf], LeafVoxel::kCount, local[leaf]); });
    owners.takeHalo(local);
    return local;
}

} // namespace

BackwardTexture::BackwardTexture(const TextureParams& params, NoiseField noise, std::vector<std::string> names)
    : mParams(params), mNoise(std::move(noise)), mNames(std::move(names))
{
}

FlowTextureStep BackwardTexture::advance(const FlowStep& step)
{
    StageClock clock;
    FlowTextureStep result;
    const Domain& domain = *step.start.domain;
    Carried before = mCarried.empty() ? first(step) : std::exchange(mCarried, {});
    for (LeafValues<float>& values : before)
        values = withHalo(domain, step.owners, std::move(values));
    if (step.isShown) {
        const auto stage = clock.enter(&StageTimes::convolve);
        result.texture = show(step, before, clock);
    }
    {
        const auto stage = clock.enter(&StageTimes::scatter);
        mCarried = pullBack(step, before, clock);
    }
    result.times = clock.times();
    result.domain = step.start.domain;
    result.refinement = step.start.refinement;
    mDomain = step.end.domain;
    ++mStep;
    return result;
}

std::array<float, 3> BackwardTexture::farthestPath(const std::array<float, 3>& displacement, double /*interval*/) const
{
    std::array<float, 3> farthest{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        farthest[axis] = longestPath(displacement[axis] / float(mParams.substeps));
    return farthest;
}

void BackwardTexture::handOver(const LeafOwners& owners, std::shared_ptr<const Domain> domain)
{
    for (LeafValues<float>& values : mCarried)
        values = handedOver(owners, *mDomain, *domain, values);
    mDomain = std::move(domain);
}

std::size_t BackwardTexture::parts() const
{
    return statePartCount(*mDomain);
}

TextureMemory::Saved BackwardTexture::save(std::size_t part) const
{
    const Domain::Leaves leaves = statePart(*mDomain, part);
    Saved saved{{}, boxOf(*mDomain, leaves)};
    for (std::size_t i = 0; i < mNames.size(); ++i)
        saved.grids.push_back(stateGrid(*mDomain, leaves, mCarried[i], mNames[i]));
    return saved;
}

void BackwardTexture::restore(std::uint64_t steps, double /*interval*/, std::shared_ptr<const Domain> domain,
                              const std::function<std::optional<VdbFile>()>& next)
{
    Carried carried;
    for (std::size_t i = 0; i < mNames.size(); ++i)
        carried.emplace_back(*domain, 0.0f, domain->own());
    StateGridReader reader(*domain, mNames);
    while (const std::optional<VdbFile> file = next()) {
        for (std::size_t i = 0; i < mNames.size(); ++i) {
            reader.read(*file, mNames[i], [&](std::size_t leaf, const float* values) {
                std::copy_n(values, LeafVoxel::kCount, carried[i][leaf]);
            });
        }
    }
    reader.finish();
    mCarried = std::move(carried);
    mDomain = std::move(domain);
    mStep = steps;
}

} // namespace vdblic
