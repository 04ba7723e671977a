#include "vdblic/lic/seeding.h"

#include <atomic>

namespace vdblic {
namespace {

VDBLIC_INLINE Float4 toVector(const std::array<float, 3>& a)
{
    return Float4{a[0], a[1], a[2], 0};
}
VDBLIC_INLINE std::array<float, 3> toArray(Float4 v)
{
    return {v[0], v[1], v[2]};
}

template<bool kShared>
VDBLIC_INLINE void deposit(std::int64_t& voxel, std::uint64_t hits)
{
    if constexpr (kShared) {
        std::atomic_ref(voxel).fetch_add(std::int64_t(hits), std::memory_order_relaxed);
    } else {
        voxel += std::int64_t(hits);
    }
}

} // namespace

TileScatter::TileScatter(const VelocityField& field, const LeafValues<std::int32_t>& input,
                         const LeafValues<std::int64_t>& accumulator, const ScatterParams& params, std::uint64_t step)
    : mField(&field), mDomain(&field.domain()), mInput(&input), mAccumulator(&accumulator), mParams(&params),
      mStep(step), mGenerations(params.method == ScatterMethod::kAuflic ? std::size_t(params.lifeSpan) : 0)
{
}

/// Carry the values of the particle at work along its path, taking up those of open voxels on the way.
/// @return whether the particle stayed inside the domain
template<bool kShared>
VDBLIC_INLINE bool TileScatter::scatterPath(const std::vector<Segment>& path, bool mayTakeUp)
{
    const float window = mParams->releaseWindow;
    std::uint64_t alive = mParticle.alive;
    std::uint32_t taken = 0;
    std::size_t deposits = 0, hits = 0;
    const auto takeUp = [&](unsigned offset) {
        if (!mOpen.isOn(offset) || Generation::count(taken) == Generation::kMaxCount) return;
        mOpen.setOff(offset);
        const auto value = std::uint32_t(mTileInput[offset]);
        taken = Generation::add(taken, value);
        alive += Hits::pack(value, 1);
    };
    if (mayTakeUp) takeUp(Domain::offset(voxelOf(path.front().start)));
    bool inside = true;
    for (const Segment& segment : path) {
        inside = visitSamples(segment, mParams->pathline.sampleSpacing, [&](const SampleBlock& block) {
            for (int i = 0; i < block.count; ++i) {
                const Int4 voxel = {block.x[i], block.y[i], block.z[i], 0};
                const int leaf = mDomain->findLeaf(voxel);
                const unsigned offset = Domain::offset(voxel);
                if (leaf < 0 || !mDomain->isActive(leaf, offset)) return false;
                if (mayTakeUp && leaf == mLeaf && block.time[i] < window) takeUp(offset);
                deposit<kShared>((*mAccumulator)[std::size_t(leaf)][offset], alive);
                ++deposits;
                hits += Hits::count(alive);
            }
            return true;
        });
        if (!inside) break;
    }
    mStats.deposits += deposits;
    mStats.hits += hits;
    mParticle.alive = alive;
    if (!mGenerations.empty()) mGenerations[mStep % mGenerations.size()] = taken;
    return inside;
}

/// Keep the particle at work for the next step, unless all its values expire with this one.
VDBLIC_INLINE void TileScatter::keep(const PathBatch& batch, std::size_t lane)
{
    if (mGenerations.empty()) {
        const std::uint64_t age = mStep - (mParticle.id >> Particle::kRankBits);
        if (age + 1 >= std::uint64_t(mParams->lifeSpan)) return;
    } else {
        std::uint32_t& expiring = mGenerations[(mStep + 1) % mGenerations.size()];
        mParticle.alive -= Generation::hits(expiring);
        expiring = 0;
        if (Hits::count(mParticle.alive) == 0) return;
    }
    mParticle.position = toArray(batch.position[lane]);
    mParticle.slope = toArray(batch.slope[lane]);
    mMoved.particles.push_back(mParticle);
    mMoved.generations.insert(mMoved.generations.end(), mGenerations.begin(), mGenerations.end());
}

template<bool kShared>
VDBLIC_INLINE void TileScatter::advanceLive(const Tile& tile)
{
    const std::size_t lifeSpan = mGenerations.size();
    mStats.particles += tile.end - tile.begin;
    for (std::size_t begin = tile.begin; begin < tile.end; begin += kLanes) {
        mBatch.count = int(std::min<std::size_t>(kLanes, tile.end - begin));
        for (std::size_t lane = 0; lane < std::size_t(mBatch.count); ++lane) {
            const Particle& particle = tile.particles.particles[begin + lane];
            mBatch.position[lane] = toVector(particle.position);
            mBatch.slope[lane] = toVector(particle.slope);
        }
        advancePaths(*mField, mParams->pathline, mBatch);
        for (std::size_t lane = 0; lane < std::size_t(mBatch.count); ++lane) {
            mParticle = tile.particles.particles[begin + lane];
            std::copy_n(tile.particles.generations.begin() + std::ptrdiff_t((begin + lane) * lifeSpan), lifeSpan,
                        mGenerations.begin());
            // It was blocked if it took up nothing in the step before.
            const bool mayTakeUp = lifeSpan > 0 && Generation::count(mGenerations[(mStep - 1) % lifeSpan]) > 0;
            const bool inside = scatterPath<kShared>(mBatch.path[lane], mayTakeUp);
            if (mayTakeUp) {
                const std::uint32_t taken = Generation::count(mGenerations[mStep % lifeSpan]);
                mStats.reused += taken > 0;
                mStats.copied += taken > 0 ? taken - 1 : 0;
            }
            if (inside) keep(mBatch, lane);
        }
    }
}

template<bool kShared>
VDBLIC_INLINE void TileScatter::releaseNew(const Tile& tile)
{
    const bool takesUp = !mGenerations.empty();
    const openvdb::Coord origin = mDomain->origin(std::size_t(tile.leaf));
    const Domain::Mask& voxels = mDomain->mask(std::size_t(tile.leaf));
    std::uint64_t nextId = tile.firstId;
    auto voxel = voxels.beginOn();
    while (voxel) {
        std::array<unsigned, kLanes> offsets;
        std::array<std::uint64_t, kLanes> ids;
        mBatch.count = 0;
        for (; voxel && mBatch.count < kLanes; ++voxel, ++nextId) {
            if (!mOpen.isOn(voxel.pos())) continue;
            const auto lane = std::size_t(mBatch.count++);
            offsets[lane] = voxel.pos();
            ids[lane] = nextId;
            const openvdb::Coord at = origin + Domain::Leaf::offsetToLocalCoord(voxel.pos());
            const Float4 centre = {float(at[0]), float(at[1]), float(at[2]), 0};
            mBatch.position[lane] = centre;
            mBatch.slope[lane] = mField->sample(centre, 0, Float4{});
        }
        advancePaths(*mField, mParams->pathline, mBatch);
        for (std::size_t lane = 0; lane < std::size_t(mBatch.count); ++lane) {
            // A particle before it in the batch may have closed the voxel meanwhile.
            if (!mOpen.isOn(offsets[lane])) continue;
            mParticle.id = ids[lane];
            mParticle.alive = takesUp ? 0 : Hits::pack(std::uint64_t(mTileInput[offsets[lane]]), 1);
            std::fill(mGenerations.begin(), mGenerations.end(), 0u);
            const bool inside = scatterPath<kShared>(mBatch.path[lane], takesUp);
            ++mStats.released;
            if (takesUp) mStats.copied += Generation::count(mGenerations[mStep % mGenerations.size()]) - 1;
            if (inside) keep(mBatch, lane);
        }
    }
}

template<bool kShared>
VDBLIC_INLINE void TileScatter::runTile(const Tile& tile)
{
    mLeaf = tile.leaf;
    mTileInput = (*mInput)[std::size_t(tile.leaf)];
    mOpen = mDomain->mask(std::size_t(tile.leaf));
    const std::size_t stepsBefore = mBatch.steps;
    advanceLive<kShared>(tile);
    releaseNew<kShared>(tile);
    mStats.steps += mBatch.steps - stepsBefore;
}

// The two kernels, each compiled for every instruction set.
VDBLIC_KERNEL void runShared(TileScatter& self, const Tile& tile)
{
    self.runTile<true>(tile);
}
VDBLIC_KERNEL void runAlone(TileScatter& self, const Tile& tile)
{
    self.runTile<false>(tile);
}

void TileScatter::run(const Tile& tile, bool shared)
{
    shared ? runShared(*this, tile) : runAlone(*this, tile);
}

} // namespace vdblic
