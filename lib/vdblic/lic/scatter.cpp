#include "vdblic/lic/scatter.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/stopwatch.h"
#include "vdblic/core/threads.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/slabs.h"
#include "vdblic/field/vector.h"
#include "vdblic/lic/accumulator.h"
#include "vdblic/lic/hits.h"
#include "vdblic/lic/particle_exchange.h"
#include "vdblic/lic/seeding.h"
#include "vdblic/lic/tile_schedule.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

/// What the own leaves have collected.
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

/// Passes leaves on that have all their hits.
class Collector {
  public:
    Collector(const Domain& domain, Accumulator& accumulator, const TakeHits& take)
        : mDomain(domain), mAccumulator(accumulator), mTake(take)
    {
    }

    void collect(Domain::Leaves leaves)
    {
        Stopwatch watch;
        forLeaves(leaves, [&](std::size_t leaf) {
            if (!mDomain.isOwn(leaf)) return;
            const Collected found = collectedIn(mAccumulator[leaf]);
            mHits += found.hits;
            mEmptyVoxels += found.emptyVoxels;
            mTake(leaf, mAccumulator[leaf]);
        });
        mAccumulator.close(leaves);
        mSeconds += watch.lap();
    }

    [[nodiscard]] Collected all() const { return {mHits, mEmptyVoxels}; }
    [[nodiscard]] double seconds() const { return mSeconds; }

  private:
    const Domain& mDomain;
    Accumulator& mAccumulator;
    const TakeHits& mTake;
    std::atomic<std::size_t> mHits = 0, mEmptyVoxels = 0;
    double mSeconds = 0;
};

/// The farthest that a path of this step can lead from its own tile, along each axis [voxels].
std::array<float, 3> longestPaths(const ScatterScene& scene)
{
    std::array<float, 3> longest{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        float slope = scene.field.largest()[int(axis)];
        for (const ParticleBins& bins : scene.arriving)
            slope = std::max(slope, bins.largestSlope()[axis] * scene.slopeScale);
        constexpr float kFarAway = 1e6f;
        longest[axis] = std::min(longestPath(slope), kFarAway);
    }
    return longest;
}

int inLeaves(float voxels)
{
    return int(std::ceil(voxels / float(LeafVoxel::kDim)));
}

/// Scatter the tiles of a slab, in parallel. Integer additions commute, so the order of tiles is free.
void scatterSlab(const Domain& domain, Slabs::Leaves leaves, const openvdb::Coord& reach,
                 std::vector<TileScatter>& workers)
{
    const auto onEveryThread = [&](const auto& work) {
        tbb::parallel_for(std::size_t(0), workers.size(), work, tbb::simple_partitioner());
    };
    constexpr int kFarReach = 3; // in leaves; with a longer reach too few tiles could be at work together
    if (workers.size() == 1) {
        for (const std::uint32_t leaf : leaves)
            workers[0].run(leaf, false);
    } else if (std::max({reach[0], reach[1], reach[2]}) <= kFarReach) {
        TileSchedule schedule(domain, leaves, reach, workers.size());
        onEveryThread([&](std::size_t thread) {
            while (const std::optional<TileSchedule::Group> group = schedule.next(thread)) {
                for (const std::uint32_t leaf : group->leaves)
                    workers[thread].run(leaf, false);
            }
        });
    } else {
        std::atomic<std::size_t> next = 0;
        onEveryThread([&](std::size_t thread) {
            for (std::size_t i = next++; i < leaves.size(); i = next++)
                workers[thread].run(leaves[i], true);
        });
    }
}

/// Scatter every tile.
/// @param accumulator its leaves are open while paths may lead to them
/// @param collect     called with the leaves of each slab that no path leads to any more
std::vector<TileScatter> scatterTiles(const ScatterScene& scene, VelocityField& field, Accumulator& accumulator,
                                      const std::function<void(Slabs::Leaves)>& collect)
{
    const std::size_t threads = threadCount();
    std::vector<TileScatter> workers;
    workers.reserve(threads);
    for (std::size_t thread = 0; thread < threads; ++thread)
        workers.emplace_back(scene);

    const std::array<float, 3> longest = longestPaths(scene);
    const openvdb::Coord reach(inLeaves(longest[0]), inLeaves(longest[1]), inLeaves(longest[2]));
    const FieldDomain& domain = field.sampledDomain();
    const Slabs slabs(*domain.texture, domain.refinement), velocitySlabs(slabs, *domain.velocity, domain.refinement);
    // The velocity's cell around a position begins up to one of its voxels before.
    const auto axis = std::size_t(slabs.axis());
    const int finer = domain.refinement.factors[axis] - 1;
    slabs.sweep(
        inLeaves(longest[axis] + float(finer)),
        [&](std::size_t slab) {
            field.fill(velocitySlabs[slab]);
            accumulator.open(slabs[slab]);
        },
        [&](std::size_t slab) {
            field.release(velocitySlabs[slab]);
            collect(slabs[slab]);
        },
        [&](std::size_t slab) {
            const Domain& texture = *domain.texture;
            if (texture.isWhole()) return scatterSlab(texture, slabs[slab], reach, workers);
            std::vector<std::uint32_t> own;
            std::copy_if(slabs[slab].begin(), slabs[slab].end(), std::back_inserter(own),
                         [&](std::uint32_t leaf) { return texture.isOwn(leaf); });
            scatterSlab(texture, own, reach, workers);
        });
    return workers;
}

/// Add up what the ranks did.
void sumOver(Exchange& exchange, ScatterStats& stats, Collected& found)
{
    std::size_t* const figures[] = {&stats.particles, &stats.blocked,    &stats.released, &stats.reused,
                                    &stats.copied,    &stats.steps,      &stats.deposits, &stats.hits,
                                    &found.hits,      &found.emptyVoxels};
    std::vector<std::uint64_t> sums;
    for (const std::size_t* figure : figures)
        sums.push_back(*figure);
    exchange.sum(sums);
    for (std::size_t i = 0; i < sums.size(); ++i)
        *figures[i] = sums[i];
}

} // namespace

Scatter::Scatter(const ScatterParams& params) : mParams(params)
{
    params.validate();
}

void Scatter::restore(std::uint64_t steps, ParticleBins particles)
{
    mStep = steps;
    mBins.clear();
    mBins.push_back(std::move(particles));
}

void Scatter::move(Exchange& exchange, const Partition& partition, const Domain& domain)
{
    handOn(exchange, partition, domain, mBins);
}

ScatterStats Scatter::step(VelocityField& field, const LeafValues<std::int32_t>& input, const TakeHits& take,
                           const Domain& next, float slopeScale, const HaloExchange* halo)
{
    const Domain& domain = field.domain();
    Accumulator accumulator(domain);
    Collector collector(domain, accumulator, take);
    const ScatterScene scene{mParams, mStep, slopeScale, field, input, accumulator, next, mBins};
    std::vector<TileScatter> workers = scatterTiles(scene, field, accumulator, [&](Slabs::Leaves leaves) {
        if (!halo) collector.collect(leaves); // paths of other ranks may lead to any
    });

    ScatterStats stats;
    mBins.clear();
    for (TileScatter& worker : workers) {
        stats += worker.stats();
        worker.leaving().freeSpare();
        mBins.push_back(std::move(worker.leaving()));
    }
    ++mStep;
    if (halo) {
        halo->addToOwners([&](std::size_t leaf) { return accumulator[leaf]; });
        collector.collect(domain.local());
        handOn(halo->exchange(), halo->partition(), next, mBins);
    }
    mSecondsToTake = collector.seconds();
    Collected found = collector.all();
    if (halo) sumOver(halo->exchange(), stats, found);
    stats.emptyVoxels = found.emptyVoxels;
    const std::size_t weight = mParams.keepsHistory() ? FadingHits::kWeight : 1;
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
