#include "vdblic/lic/scatter.h"

#include "vdblic/core/errors.h"
#include "vdblic/lic/seeding.h"
#include "vdblic/lic/tile_schedule.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <functional>

namespace vdblic {
namespace {

/// The hits in an accumulator, to be compared with the hits that were deposited.
std::size_t countHits(const Domain& domain, const LeafValues<std::int64_t>& accumulator)
{
    return tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, domain.leafCount()), std::size_t(0),
        [&](const tbb::blocked_range<std::size_t>& range, std::size_t hits) {
            for (std::size_t leaf = range.begin(); leaf < range.end(); ++leaf) {
                for (int i = 0; i < Domain::kLeafVoxels; ++i) // what is outside counts nothing
                    hits += Hits::count(std::uint64_t(accumulator[leaf][i]));
            }
            return hits;
        },
        std::plus<>());
}

/// How far from its own leaf a path of this step can reach, in leaves along each axis.
///
/// A step leads no farther than the largest of the slopes that make it; the Hermite curve swings beyond its ends by at
/// most 4/27 of the slope at each.
openvdb::Coord reachOf(const ScatterScene& scene)
{
    constexpr float kSwing = 1 + 2 * 4.0f / 27, kRounding = 1; // voxels
    openvdb::Coord reach;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        float slope = scene.field.largest()[int(axis)];
        for (const ParticleBins& bins : scene.arriving)
            slope = std::max(slope, bins.largestSlope()[axis] * scene.slopeScale);
        constexpr float kFarAway = 1e6f;
        const float voxels = std::min(kSwing * slope + kRounding, kFarAway);
        reach[int(axis)] = int(std::ceil(voxels / float(Domain::Leaf::DIM)));
    }
    return reach;
}

/// Scatter every tile, in parallel. Integer additions commute, so the order of tiles is free.
std::vector<TileScatter> scatterTiles(const ScatterScene& scene)
{
    const std::size_t leaves = scene.field.domain().leafCount();
    const std::size_t threads =
        std::min(std::size_t(tbb::this_task_arena::max_concurrency()),
                 tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
    std::vector<TileScatter> workers;
    workers.reserve(threads);
    for (std::size_t thread = 0; thread < threads; ++thread)
        workers.emplace_back(scene);

    constexpr int kFarReach = 3; // leaves: beyond, too few tiles could be at work together
    const openvdb::Coord reach = reachOf(scene);
    if (threads == 1) {
        for (std::size_t leaf = 0; leaf < leaves; ++leaf)
            workers[0].run(leaf, false);
    } else if (std::max({reach[0], reach[1], reach[2]}) <= kFarReach) {
        TileSchedule schedule(scene.field.domain(), reach, threads);
        tbb::parallel_for(
            std::size_t(0), threads,
            [&](std::size_t thread) {
                while (const std::optional<TileSchedule::Group> group = schedule.next(thread)) {
                    for (std::size_t leaf = group->begin; leaf < group->end; ++leaf)
                        workers[thread].run(leaf, false);
                }
            },
            tbb::simple_partitioner());
    } else {
        std::atomic<std::size_t> next = 0;
        tbb::parallel_for(
            std::size_t(0), threads,
            [&](std::size_t thread) {
                for (std::size_t leaf = next++; leaf < leaves; leaf = next++)
                    workers[thread].run(leaf, true);
            },
            tbb::simple_partitioner());
    }
    return workers;
}

} // namespace

void ScatterParams::validate() const
{
    constexpr int kMaxLifeSpan = 1000;
    if (lifeSpan < 1 || lifeSpan > kMaxLifeSpan) {
        throw ParameterError(fmt::format("life span {} must lie between 1 and {} frames", lifeSpan, kMaxLifeSpan));
    }
    if (!(releaseWindow > 0 && releaseWindow <= 1)) {
        throw ParameterError(fmt::format("release window {} must be above 0 and at most 1 step", releaseWindow));
    }
    pathline.validate();
}

ScatterStats& ScatterStats::operator+=(const ScatterStats& other)
{
    particles += other.particles;
    blocked += other.blocked;
    released += other.released;
    reused += other.reused;
    copied += other.copied;
    steps += other.steps;
    deposits += other.deposits;
    hits += other.hits;
    return *this;
}

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

LeafValues<std::int64_t> makeAccumulator(const Domain& domain)
{
    LeafValues<std::int64_t> accumulator(domain, 0);
    tbb::parallel_for(std::size_t(0), domain.leafCount(), [&](std::size_t leaf) {
        for (auto voxel = domain.mask(leaf).beginOff(); voxel; ++voxel)
            accumulator[leaf][voxel.pos()] = Hits::kOutside;
    });
    return accumulator;
}

ScatterStats Scatter::step(const VelocityField& field, const LeafValues<std::int32_t>& input,
                           const LeafValues<std::int64_t>& accumulator, const Domain& next, float slopeScale)
{
    const Domain& domain = field.domain();
    ScatterScene scene{mParams, mStep, slopeScale, field, input, accumulator, next, mBins, {0}};
    scene.firstRank.reserve(domain.leafCount() + 1);
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf)
        scene.firstRank.push_back(scene.firstRank.back() + domain.mask(leaf).countOn());

    std::vector<TileScatter> workers = scatterTiles(scene);

    ScatterStats stats;
    mBins.clear();
    for (TileScatter& worker : workers) {
        stats += worker.stats();
        mBins.push_back(std::move(worker.leaving()));
    }
    ++mStep;
    if (countHits(domain, accumulator) != stats.hits) {
        throw InputError(
            fmt::format("a voxel collected more than {} hits in one step: the flow has a sink that swallows "
                        "the domain; use a shorter life span or mask the sink",
                        Hits::kCountMask));
    }
    return stats;
}

} // namespace vdblic
