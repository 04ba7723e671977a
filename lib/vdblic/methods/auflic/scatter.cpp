#include "vdblic/methods/auflic/scatter.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/paging.h"
#include "vdblic/core/threads.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/slabs.h"
#include "vdblic/field/vector.h"
#include "vdblic/lic/hits.h"
#include "vdblic/lic/path_reach.h"
#include "vdblic/methods/auflic/accumulator.h"
#include "vdblic/methods/auflic/fading_values.h"
#include "vdblic/methods/auflic/seeding.h"
#include "vdblic/methods/auflic/single_value.h"
#include "vdblic/methods/auflic/value_window.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

/// Hits in the own leaves, and number of voxels without a hit.
struct Collected {
    std::size_t hits = 0, emptyVoxels = 0;
};
VDBLIC_KERNEL Collected collectedIn(const std::int64_t* hits)
{
    UnsignedLong4 sum{}, empty{};
    for (int i = 0; i < LeafVoxel::kCount; i += 4) { // Hits::kOutside has a count of 0
        UnsignedLong4 words;
        __builtin_memcpy(&words, hits + i, sizeof words);
        sum += words & Hits::kCountMask;
        empty -= UnsignedLong4(words == 0); // true is −1
    }
    return {sum[0] + sum[1] + sum[2] + sum[3], empty[0] + empty[1] + empty[2] + empty[3]};
}

/// Emits each leaf once no remaining seed can reach it.
class Collector {
  public:
    Collector(const Domain& domain, Accumulator& accumulator, const TakeHits& take, StageClock& clock)
        : mDomain(domain), mAccumulator(accumulator), mTake(take), mClock(clock)
    {
    }

    void collect(Domain::Leaves leaves)
    {
        const auto stage = mClock.enter(&StageTimes::convolve);
        forLeaves(leaves, [&](std::size_t leaf) {
            if (!mDomain.isOwn(leaf)) return;
            const Collected found = collectedIn(mAccumulator[leaf]);
            mHits += found.hits;
            mEmptyVoxels += found.emptyVoxels;
            mTake(leaf, mAccumulator[leaf]);
        });
        mAccumulator.close(leaves);
    }

    [[nodiscard]] Collected all() const { return {mHits, mEmptyVoxels}; }

  private:
    const Domain& mDomain;
    Accumulator& mAccumulator;
    const TakeHits& mTake;
    StageClock& mClock;
    std::atomic<std::size_t> mHits = 0, mEmptyVoxels = 0;
};

/// The farthest distance of this step's paths from their tiles along an axis [voxels].
float longestPathAlong(std::size_t axis, const ScatterScene& scene)
{
    float slope = scene.field.largest()[axis];
    for (const ParticleBins& bins : scene.arriving)
        slope = std::max(slope, bins.largestSlope()[axis] * scene.slopeScale);
    return longestPath(slope);
}

/// Scatter a slab's tiles. Integer additions commute, so any thread may take any tile.
template<typename Carried>
void scatterSlab(Slabs::Leaves leaves, std::vector<TileScatter<Carried>>& workers)
{
    std::atomic<std::size_t> next = 0;
    const auto scatter = [&](std::size_t thread) {
        for (std::size_t i = next++; i < leaves.size(); i = next++) {
            paging::breathe(4 * paging::kLeafBytes); // with particles, hits and input
            workers[thread].run(leaves[i], workers.size() > 1);
        }
    };
    tbb::parallel_for(std::size_t(0), workers.size(), scatter, tbb::simple_partitioner());
}

/// ScatterMethod::scatterTiles
template<typename Carried>
ScatterStats scatterTiles(const ScatterScene& scene, VelocityField& field, Accumulator& accumulator,
                          const std::function<void(Slabs::Leaves)>& fill,
                          const std::function<void(Slabs::Leaves)>& collect)
{
    const std::size_t threads = threadCount();
    std::vector<TileScatter<Carried>> workers;
    workers.reserve(threads);
    for (std::size_t thread = 0; thread < threads; ++thread)
        workers.emplace_back(scene);

    const FrameDomain& domain = field.sampledDomain();
    const Slabs slabs(*domain.texture, domain.refinement), velocitySlabs(slabs, *domain.velocity, domain.refinement);
    // The velocity's cell around a position begins up to one velocity voxel before it.
    const auto axis = std::size_t(slabs.axis());
    const int finer = domain.refinement.factors[axis] - 1;
    slabs.sweep(
        leavesReached(longestPathAlong(axis, scene) + float(finer)),
        [&](std::size_t slab) {
            fill(velocitySlabs[slab]);
            accumulator.open(slabs[slab]);
        },
        [&](std::size_t slab) {
            field.release(velocitySlabs[slab]);
            collect(slabs[slab]);
        },
        [&](std::size_t slab) {
            const Domain& texture = *domain.texture;
            if (texture.isWhole()) return scatterSlab(slabs[slab], workers);
            std::vector<std::uint32_t> own;
            std::copy_if(slabs[slab].begin(), slabs[slab].end(), std::back_inserter(own),
                         [&](std::uint32_t leaf) { return texture.isOwn(leaf); });
            scatterSlab<Carried>(own, workers);
        });

    ScatterStats stats;
    scene.arriving.clear();
    for (TileScatter<Carried>& worker : workers) {
        stats += worker.stats();
        worker.leaving().freeSpare();
        scene.arriving.push_back(std::move(worker.leaving()));
    }
    return stats;
}

template<typename Carried>
constexpr ScatterMethod kScatter = {&Carried::words, Carried::kWeight, std::is_same_v<Carried, FadingValues>,
                                    &scatterTiles<Carried>};

/// Sum the statistics of all ranks.
void sumOver(const LeafOwners& owners, ScatterStats& stats, Collected& found)
{
    std::size_t* const figures[] = {&stats.particles, &stats.blocked,    &stats.released, &stats.reused,
                                    &stats.copied,    &stats.steps,      &stats.deposits, &stats.hits,
                                    &found.hits,      &found.emptyVoxels};
    std::vector<std::uint64_t> sums;
    for (const std::size_t* figure : figures)
        sums.push_back(*figure);
    owners.sum(sums);
    for (std::size_t i = 0; i < sums.size(); ++i)
        *figures[i] = sums[i];
}

} // namespace

constinit const ScatterMethod kScatterFading = kScatter<FadingValues>;
constinit const ScatterMethod kScatterWindow = kScatter<ValueWindow>;
constinit const ScatterMethod kScatterSingle = kScatter<SingleValue>;

Scatter::Scatter(const TextureParams& params) : mParams(params)
{
    params.validate();
}

void Scatter::restore(std::uint64_t steps, ParticleBins particles)
{
    mStep = steps;
    mBins.clear();
    mBins.push_back(std::move(particles));
}

void Scatter::handOver(const LeafOwners& owners, const Domain& domain)
{
    if (!owners.areSeveral()) return;
    const std::size_t words = mBins.front().words();
    ParticleBins arrived(domain.leafCount(), words);
    std::vector<Particle> particles;
    std::vector<std::uint32_t> wordsOfAll;
    owners.send(
        domain,
        [&](std::size_t leaf, Exchange::Bytes& message) {
            particles.clear();
            wordsOfAll.clear();
            for (ParticleBins& some : mBins)
                some.take(leaf, particles, wordsOfAll, some);
            if (particles.empty()) return;
            put(message, std::uint32_t(particles.size()));
            put(message, particles.data(), particles.size());
            put(message, wordsOfAll.data(), wordsOfAll.size());
        },
        [&](std::size_t leaf, MessageReader& message) {
            particles.resize(message.get<std::uint32_t>());
            wordsOfAll.resize(particles.size() * words);
            message.get(particles.data(), particles.size());
            message.get(wordsOfAll.data(), wordsOfAll.size());
            for (std::size_t i = 0; i < particles.size(); ++i)
                arrived.add(leaf, particles[i], wordsOfAll.data() + i * words);
        });
    for (ParticleBins& some : mBins)
        some.freeSpare();
    mBins.push_back(std::move(arrived));
}

ScatterStats Scatter::step(VelocityField& field, const LeafValues<std::int32_t>& input, const TakeHits& take,
                           const Domain& next, float slopeScale, const LeafOwners& owners, StageClock& clock)
{
    const Domain& domain = field.domain();
    Accumulator accumulator(domain);
    Collector collector(domain, accumulator, take, clock);
    const auto fill = [&](Slabs::Leaves leaves) {
        const auto stage = clock.enter(&StageTimes::load);
        field.fill(leaves);
    };
    const auto collect = [&](Slabs::Leaves leaves) {
        if (!owners.areSeveral()) collector.collect(leaves); // other ranks' paths may reach any leaf
    };
    const ScatterScene scene{mParams, mStep, slopeScale, field, input, accumulator, next, mBins};
    ScatterStats stats = method().scatterTiles(scene, field, accumulator, fill, collect);
    ++mStep;
    if (owners.areSeveral()) {
        owners.addHits([&](std::size_t leaf) { return accumulator[leaf]; });
        collector.collect(domain.local());
    }
    handOver(owners, next);
    Collected found = collector.all();
    sumOver(owners, stats, found);
    stats.emptyVoxels = found.emptyVoxels;
    const std::uint64_t weight = method().weight;
    if (found.hits != stats.hits) {
        throw InputError(
            fmt::format("a voxel collected more than {} hits in one step: the flow has a sink that swallows "
                        "the domain; use a shorter life span or mask the sink",
                        Hits::kCountMask / weight));
    }
    stats.hits /= weight;
    return stats;
}

} // namespace vdblic
