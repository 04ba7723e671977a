#include "bench/engine/scap_auflic.h"

#include "bench/engine/euler_uflic.h"
#include "vdblic/field/domain_rows.h"
#include "vdblic/lic/hits.h"
#include "vdblic/methods/auflic/feedback.h"

#include <algorithm>
#include <utility>

namespace vdblic::bench {
namespace {

VDBLIC_KERNEL void trace(const VelocityField& field, const LeafWindow& window, const openvdb::Coord& tile,
                         const TextureParams& params, PathBatch& batch, PathSamples& samples)
{
    advancePaths(field, field.window(tile), params.pathline, batch);
    samplePaths(batch, field.domain(), window, params.pathline.sampleSpacing, params.releaseWindow, samples);
}

} // namespace

ScapAuflic::ScapAuflic(int lifeSpan, float releaseWindow, NoiseField noise) : mNoise(std::move(noise))
{
    mParams.lifeSpan = lifeSpan;
    mParams.releaseWindow = releaseWindow;
}

void ScapAuflic::extend(const VelocityField& field, Path& path)
{
    const Domain& domain = field.domain();
    const Int4 voxel = voxelOf(path.position);
    Path::Step& step = path.steps.emplace_back();
    step.start = std::uint32_t(domain.findLeaf(voxel)) << 9 | Domain::offset(voxel);
    mBatch.lanes = 1;
    mBatch.position.setLane(0, path.position);
    mBatch.slope.setLane(0, path.slope);
    const openvdb::Coord tile = domain.origin(step.start >> 9);
    const LeafWindow window(domain, tile);
    const std::size_t before = mBatch.steps;
    trace(field, window, tile, mParams, mBatch, mSamples);
    mStats.steps += mBatch.steps - before;
    path.position = mBatch.position.lane(0);
    path.slope = mBatch.slope.lane(0);
    for (const PathSamples::Run& run : mSamples.runs) {
        for (int i = 0; i < run.count[0] && !path.ended; ++i) {
            const PathSamples::Voxel sample =
                mSamples.find(mSamples.rows[run.firstRow + std::size_t(i)].voxel(0), window);
            path.ended = sample.leaf < 0 || !domain.isActive(sample.leaf, sample.offset);
            if (path.ended) break;
            step.voxels.push_back(std::uint32_t(sample.leaf) << 9 | sample.offset);
            step.early += i < run.early[0];
        }
    }
    path.ended = path.ended || !covers(domain, path.position);
}

/// Release a seed in every open voxel of the tile that the path passes within the release window, and scatter the
/// values.
/// @return false if there was none
bool ScapAuflic::releaseAlong(std::size_t k, const std::vector<VelocityField>& fields, std::size_t leaf, Path& path)
{
    struct Seed {
        std::size_t from;
        std::uint32_t value;
    };
    std::vector<Seed> seeds;
    const auto releaseIn = [&](std::uint32_t voxel, std::size_t from) {
        if (voxel >> 9 != leaf || !mOpen.isOn(voxel & 511)) return;
        mOpen.setOff(voxel & 511);
        seeds.push_back({from, std::uint32_t(mInput[leaf][voxel & 511])});
    };
    const Path::Step& now = path.steps.front();
    releaseIn(now.start, 0);
    for (std::size_t i = 0; i < now.early; ++i)
        releaseIn(now.voxels[i], i);
    if (seeds.empty()) return false;

    while (!path.ended && path.steps.size() < std::size_t(mParams.lifeSpan))
        extend(fields[k + path.steps.size()], path);
    for (const Seed& seed : seeds) {
        for (std::size_t step = 0; step < path.steps.size(); ++step) {
            const auto& voxels = path.steps[step].voxels;
            Accumulator& bucket = mBuckets[(k + step) % mBuckets.size()];
            const std::size_t first = step == 0 ? seed.from : 0;
            for (std::size_t i = first; i < voxels.size(); ++i)
                bucket[voxels[i] >> 9][voxels[i] & 511] += std::int64_t(Hits::pack(seed.value, 1));
            mStats.deposits += voxels.size() - first;
            mStats.hits += voxels.size() - first;
        }
    }
    return true;
}

void ScapAuflic::seedTile(std::size_t k, const std::vector<VelocityField>& fields, std::size_t leaf)
{
    const VelocityField& field = fields[k];
    const Domain& domain = field.domain();
    mOpen = domain.mask(leaf);
    const auto save = [&](Path&& path) {
        path.steps.erase(path.steps.begin());
        if (!path.steps.empty()) mNext[path.steps.front().start >> 9].push_back(std::move(path));
    };
    // Pathlines of the previous process, the oldest first; a pathline that finds no open voxel is deleted.
    std::vector<Path>& saved = mSaved[leaf];
    std::sort(saved.begin(), saved.end(), [](const Path& a, const Path& b) { return a.id < b.id; });
    for (Path& path : saved) {
        ++mStats.particles;
        if (releaseAlong(k, fields, leaf, path)) save(std::move(path));
    }
    saved.clear();

    std::uint64_t rank = mFirstRank[leaf];
    for (auto voxel = domain.mask(leaf).beginOn(); voxel; ++voxel, ++rank) {
        if (!mOpen.isOn(voxel.pos())) continue;
        const openvdb::Coord at = domain.origin(leaf) + Domain::Leaf::offsetToLocalCoord(voxel.pos());
        Path path;
        path.id = std::uint64_t(k) << Particle::kVoxelBits | rank;
        path.position = Float4{float(at[0]), float(at[1]), float(at[2]), 0};
        path.slope = field.sample(path.position, 0, Float4{});
        extend(field, path);
        ++mStats.released;
        if (releaseAlong(k, fields, leaf, path)) save(std::move(path));
    }
}

LeafValues<float> ScapAuflic::scatteringProcess(std::size_t k, std::vector<VelocityField>& fields)
{
    const Domain& domain = fields[k].domain();
    mStats = {};
    if (mBuckets.empty()) {
        mInput = noiseInput(domain, mNoise);
        for (int i = 0; i < mParams.lifeSpan; ++i)
            mBuckets.push_back(makeBucket(domain));
        mFirstRank.assign(1, 0);
        for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf)
            mFirstRank.push_back(mFirstRank.back() + domain.mask(leaf).countOn());
        mSaved.resize(domain.leafCount());
    }
    mNext.clear();
    mNext.resize(domain.leafCount());
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf)
        seedTile(k, fields, leaf);
    mSaved = std::move(mNext);

    LeafValues<float> texture = takeTexture(domain, mBuckets[k % mBuckets.size()], mInput, mStats);
    mInput = feedForward(fields[k], texture, domain, mNoise, FeedbackParams{}, k);
    return texture;
}

} // namespace vdblic::bench
