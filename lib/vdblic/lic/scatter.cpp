#include "vdblic/lic/scatter.h"

#include "vdblic/core/errors.h"
#include "vdblic/lic/seeding.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>

#include <functional>

namespace vdblic {
namespace {

/// The hits in an accumulator, to be compared with the hits that were deposited.
std::size_t countHits(const LeafValues<std::int64_t>& accumulator, std::size_t leaves)
{
    return tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, leaves), std::size_t(0),
        [&](const tbb::blocked_range<std::size_t>& range, std::size_t hits) {
            for (std::size_t leaf = range.begin(); leaf < range.end(); ++leaf) {
                for (int i = 0; i < Domain::kLeafVoxels; ++i)
                    hits += Hits::count(std::uint64_t(accumulator[leaf][i]));
            }
            return hits;
        },
        std::plus<>());
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

ScatterStats Scatter::step(const VelocityField& field, const LeafValues<std::int32_t>& input,
                           const LeafValues<std::int64_t>& accumulator, float slopeScale)
{
    const Domain& domain = field.domain();
    sortIntoTiles(domain, slopeScale);

    std::vector<std::uint64_t> firstRank(domain.leafCount() + 1, 0);
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf) {
        firstRank[leaf + 1] = firstRank[leaf] + domain.mask(leaf).countOn();
    }

    // Deposits of neighbouring tiles may meet in a voxel; integer additions commute, so their order is free.
    const bool shared = tbb::this_task_arena::max_concurrency() > 1;
    tbb::enumerable_thread_specific<TileScatter> workers(
        [&] { return TileScatter(field, input, accumulator, mParams, mStep); });
    tbb::parallel_for(std::size_t(0), domain.leafCount(), [&](std::size_t leaf) {
        const Tile tile{int(leaf), mSorted, mTileBegin[leaf], mTileBegin[leaf + 1],
                        mStep << Particle::kRankBits | firstRank[leaf]};
        workers.local().run(tile, shared);
    });

    ScatterStats stats;
    mMoved.clear();
    for (TileScatter& worker : workers) {
        stats += worker.stats();
        mMoved.push_back(std::move(worker.moved()));
    }
    mSorted = {};
    ++mStep;
    if (countHits(accumulator, domain.leafCount()) != stats.hits) {
        throw InputError(
            fmt::format("a voxel collected more than {} hits in one step: the flow has a sink that swallows "
                        "the domain; use a shorter life span or mask the sink",
                        Hits::kCountMask));
    }
    return stats;
}

void Scatter::sortIntoTiles(const Domain& domain, float slopeScale)
{
    struct Source {
        std::uint64_t id;
        std::uint32_t store, index;
    };
    constexpr int kOutside = -1;

    // Which tile each particle is in now; those outside the domain end here.
    std::vector<std::vector<int>> tileOf(mMoved.size());
    mTileBegin.assign(domain.leafCount() + 1, 0);
    for (std::size_t store = 0; store < mMoved.size(); ++store) {
        const std::vector<Particle>& particles = mMoved[store].particles;
        if (particles.size() > std::numeric_limits<std::uint32_t>::max()) throw std::length_error("too many particles");
        tileOf[store].resize(particles.size());
        tbb::parallel_for(std::size_t(0), particles.size(), [&](std::size_t i) {
            const auto& p = particles[i].position;
            const Float4 position = {p[0], p[1], p[2], 0};
            tileOf[store][i] = domain.contains(position) ? domain.findLeaf(voxelOf(position)) : kOutside;
        });
        for (const int leaf : tileOf[store]) {
            if (leaf != kOutside) ++mTileBegin[std::size_t(leaf) + 1];
        }
    }
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf)
        mTileBegin[leaf + 1] += mTileBegin[leaf];

    std::vector<Source> sources(mTileBegin.back());
    std::vector<std::size_t> next(mTileBegin.begin(), mTileBegin.end() - 1);
    for (std::size_t store = 0; store < mMoved.size(); ++store) {
        for (std::size_t i = 0; i < tileOf[store].size(); ++i) {
            if (const int leaf = tileOf[store][i]; leaf != kOutside) {
                sources[next[std::size_t(leaf)]++] = {mMoved[store].particles[i].id, std::uint32_t(store),
                                                      std::uint32_t(i)};
            }
        }
    }

    // The order of visits inside a tile depends on the particles alone: oldest first, then by release voxel.
    const bool hasGenerations = mParams.method == ScatterMethod::kAuflic;
    const auto lifeSpan = std::size_t(mParams.lifeSpan);
    mSorted.particles.resize(sources.size());
    mSorted.generations.resize(hasGenerations ? sources.size() * lifeSpan : 0);
    tbb::parallel_for(std::size_t(0), domain.leafCount(), [&](std::size_t leaf) {
        std::sort(sources.begin() + std::ptrdiff_t(mTileBegin[leaf]),
                  sources.begin() + std::ptrdiff_t(mTileBegin[leaf + 1]),
                  [](const Source& a, const Source& b) { return a.id < b.id; });
        for (std::size_t to = mTileBegin[leaf]; to < mTileBegin[leaf + 1]; ++to) {
            const ParticleStore& from = mMoved[sources[to].store];
            Particle& particle = mSorted.particles[to] = from.particles[sources[to].index];
            for (float& slope : particle.slope)
                slope *= slopeScale;
            if (hasGenerations) {
                std::copy_n(from.generations.begin() + std::ptrdiff_t(sources[to].index * lifeSpan), lifeSpan,
                            mSorted.generations.begin() + std::ptrdiff_t(to * lifeSpan));
            }
        }
    });
    mMoved.clear();
}

} // namespace vdblic
