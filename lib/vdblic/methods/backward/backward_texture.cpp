#include "vdblic/methods/backward/backward_texture.h"

#include "vdblic/field/for_leaves.h"
#include "vdblic/lic/path_reach.h"
#include "vdblic/methods/hand_over.h"
#include "vdblic/methods/state_grids.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

constexpr char kNoise[] = "noise", kOffset[] = "offset", kTexture[] = "texture";

/// Call visit(name, values) for all carried values. @param name of the checkpoint's grid
template<typename Carried, typename Visit>
void forCarried(Carried& carried, const Visit& visit)
{
    if (carried.particles.values.tree()) {
        visit(kNoise, carried.particles.values);
        visit(kOffset, carried.particles.offsets);
    }
    if (carried.texture.tree()) visit(kTexture, carried.texture);
}

/// Read a number of a checkpoint. An impossible offset is read as none.
void setNumber(float stored, float& number)
{
    number = stored;
}
void setNumber(float stored, std::int32_t& offset)
{
    offset = stored >= 0 && stored < float(CellParticles::kOffsetEnd) ? std::int32_t(stored) : 0;
}

/// Extend values on a domain's own leaves to all local ones. Collective.
template<typename T>
LeafValues<T> withHalo(const Domain& domain, const LeafOwners& owners, LeafValues<T> own)
{
    if (domain.isWhole()) return own;
    LeafValues<T> local(domain, T(0));
    forLeaves(domain.own(), [&](std::size_t leaf) { std::copy_n(own[leaf], LeafVoxel::kCount, local[leaf]); });
    owners.takeHalo(local);
    return local;
}

} // namespace

BackwardTexture::BackwardTexture(const TextureParams& params, NoiseField noise, Parts carries)
    : mParams(params), mNoise(std::move(noise)), mCarries(carries)
{
}

TextureFrame BackwardTexture::advance(const FlowStep& step)
{
    StageClock clock;
    TextureFrame result(step);
    const Domain& domain = *step.start.domain.texture;
    Carried before = mCarried ? *std::exchange(mCarried, std::nullopt) : first(step);
    forCarried(before, [&](const char*, auto& values) { values = withHalo(domain, step.owners, std::move(values)); });
    if (step.isShown) {
        const auto stage = clock.enter(&StageTimes::convolve);
        result.texture = show(step, before, clock);
    }
    {
        const auto stage = clock.enter(&StageTimes::scatter);
        mCarried = pullBack(step, before, clock);
    }
    result.times = clock.times();
    mDomain = step.end.domain.texture;
    ++mStep;
    return result;
}

Lengths<Space::kTexture> BackwardTexture::farthestPath(const Speeds<Space::kTexture, Per::kFrame>& fastest,
                                                       double /*seconds*/) const
{
    Lengths<Space::kTexture> farthest;
    for (std::size_t axis = 0; axis < 3; ++axis)
        farthest.along[axis] = longestPath(fastest[axis] / float(mParams.substeps));
    return farthest;
}

void BackwardTexture::handOver(const LeafOwners& owners, std::shared_ptr<const Domain> domain)
{
    forCarried(*mCarried, [&](const char*, auto& values) { values = handedOver(owners, *mDomain, *domain, values); });
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
    forCarried(*mCarried, [&](const char* name, const auto& values) {
        saved.grids.push_back(stateGrid(*mDomain, leaves, values, name));
    });
    return saved;
}

void BackwardTexture::restore(std::uint64_t steps, double /*seconds*/, std::shared_ptr<const Domain> domain,
                              const std::function<std::optional<VdbFile>()>& next)
{
    Carried carried;
    if (mCarries.particles) carried.particles = {{*domain, 0.0f, domain->own()}, {*domain, 0, domain->own()}};
    if (mCarries.texture) carried.texture = {*domain, 0.0f, domain->own()};
    std::vector<std::string> names;
    forCarried(carried, [&](const char* name, const auto&) { names.emplace_back(name); });
    StateGridReader reader(*domain, names);
    while (const std::optional<VdbFile> file = next()) {
        forCarried(carried, [&](const char* name, auto& to) {
            reader.read(*file, name, [&](std::size_t leaf, const float* values) {
                for (int i = 0; i < LeafVoxel::kCount; ++i)
                    setNumber(values[i], to[leaf][i]);
            });
        });
    }
    reader.finish();
    mCarried = std::move(carried);
    mDomain = std::move(domain);
    mStep = steps;
}

} // namespace vdblic
