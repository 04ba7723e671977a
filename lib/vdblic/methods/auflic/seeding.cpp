#include "vdblic/methods/auflic/seeding.h"

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/period_position.h"
#include "vdblic/lic/hits.h"
#include "vdblic/methods/auflic/fading_values.h"
#include "vdblic/methods/auflic/release_turn.h"
#include "vdblic/methods/auflic/single_value.h"
#include "vdblic/methods/auflic/value_window.h"

#include <algorithm>
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

/// An accumulator leaf entirely outside, for window slots without a leaf.
std::int64_t* outsideLeaf()
{
    static std::array<std::int64_t, LeafVoxel::kCount> words = [] {
        std::array<std::int64_t, LeafVoxel::kCount> all;
        all.fill(Hits::kOutside);
        return all;
    }();
    return words.data(); // shared by all threads: deposit() never writes to a voxel outside
}

/// Add hits to a voxel. @return false if it is outside the domain
template<bool kShared>
VDBLIC_INLINE bool deposit(std::int64_t& voxel, std::uint64_t hits)
{
    if constexpr (kShared) {
        const std::atomic_ref shared(voxel);
        if (shared.load(std::memory_order_relaxed) < 0) return false;
        shared.fetch_add(std::int64_t(hits), std::memory_order_relaxed);
    } else {
        if (voxel < 0) return false;
        voxel += std::int64_t(hits);
    }
    return true;
}

} // namespace

template<typename Carried>
TileScatter<Carried>::TileScatter(const ScatterScene& scene)
    : mScene(scene), mDomain(scene.field.domain()), mCarried(scene.params, scene.step),
      mWordCount(Carried::words(scene.params)), mIsPeriodic(!scene.next.period().isNone()), mWords(mWordCount),
      mLeaving(scene.next.leafCount(), mWordCount)
{
}

/// Deposit the particle's values along its path, and collect those of open voxels on the way.
/// @return whether the particle stayed inside the domain
template<typename Carried>
template<bool kShared>
VDBLIC_INLINE bool TileScatter<Carried>::scatterPath(int lane, bool mayTakeUp)
{
    std::uint64_t alive = mParticle.alive;
    std::uint32_t* const now = mCarried.now(mParticle, mWords.data());
    std::size_t deposits = 0, hits = 0;
    std::uint32_t taken = 0;
    const auto takeUp = [&](unsigned offset) {
        if (!mOpen.isOn(offset) || Carried::isFull(now)) return;
        mOpen.setOff(offset);
        Carried::add(alive, now, std::uint64_t(mInput[offset]));
        ++taken;
    };
    const auto add = [&](WindowVoxel sample) {
        if (__builtin_expect(!sample.isFar(), 1))
            return deposit<kShared>(mTarget[std::size_t(sample.slot())][sample.offset()], alive);
        const PathSamples::Voxel& voxel = mSamples.far[sample.farIndex()];
        return voxel.leaf >= 0 && deposit<kShared>(mScene.accumulator[std::size_t(voxel.leaf)][voxel.offset], alive);
    };
    if (mayTakeUp) takeUp(Domain::offset(voxelOf(mBatch.segments.front().start.lane(lane))));
    bool inside = true;
    for (const PathSamples::Run& run : mSamples.runs) {
        if (!(run.lanes >> lane & 1)) continue;
        const int early = mayTakeUp ? run.early[lane] : 0, count = run.count[lane];
        const PathSamples::Row* const first = &mSamples.rows[run.firstRow];
        const PathSamples::Row *row = first, *const late = first + early, *const end = first + count;
        for (; row != late; ++row) {
            const WindowVoxel sample = row->voxel(lane);
            if (sample.slot() == LeafWindow::kCentre) takeUp(sample.offset());
            inside = add(sample);
            if (!inside) break;
            hits += Hits::count(alive);
        }
        if (inside) {
            while (row != end && (inside = add(row->voxel(lane))))
                ++row;
            hits += std::size_t(row - late) * Hits::count(alive);
        }
        deposits += std::size_t(row - first);
        if (!inside) break;
    }
    mStats.deposits += deposits;
    mStats.hits += hits;
    mParticle.alive = alive;
    mTaken = taken;
    return inside;
}

/// Keep the particle for the next step if it has values left.
template<typename Carried>
VDBLIC_INLINE void TileScatter<Carried>::keep(int lane)
{
    if (!mCarried.age(mParticle, mWords.data())) return;
    const WindowVoxel end{mEnds[lane]};
    Float4 position = mBatch.position.lane(lane);
    unsigned offset = end.offset();
    int leaf = end.slot() == LeafWindow::kElsewhere ? mScene.next.findLeaf(voxelOf(position))
                                                    : mNextWindow.leaves[std::size_t(end.slot())];
    if (mIsPeriodic) {
        position = wrapped(mScene.next.period(), position);
        const Int4 voxel = voxelOf(position); // rounding may have moved it to the next one
        leaf = mScene.next.findLeaf(voxel);
        offset = Domain::offset(voxel);
    }
    if (leaf < 0 || !mScene.next.isActive(leaf, offset)) return;
    mParticle.position = toArray(position);
    mParticle.slope = toArray(mBatch.slope.lane(lane));
    mLeaving.add(std::size_t(leaf), mParticle, mWords.data());
}

/// Advance the batch by the step, and find the voxels on its paths and at their ends.
template<typename Carried>
VDBLIC_INLINE void TileScatter<Carried>::trace()
{
    const PathlineParams& params = mScene.params.pathline;
    advancePaths(mScene.field, mFieldWindow, params, mBatch);
    const float window = std::min(mScene.params.releaseWindow * float(mScene.params.substeps), 1.0f); // of this step
    samplePaths(mBatch, mDomain, mWindow, params.sampleSpacing, window, mSamples);
    const Vector8& end = mBatch.position;
    const Int8 x = floorToInt(end.x + 0.5f), y = floorToInt(end.y + 0.5f), z = floorToInt(end.z + 0.5f);
    storeLanes(WindowVoxel::encode(mNextWindow.slots(x, y, z), x, y, z), mEnds);
}

/// Load the tile's particles of earlier steps, and sort their turns if the tile releases seeds.
template<typename Carried>
void TileScatter<Carried>::takeArriving()
{
    mParticles.clear();
    mParticleWords.clear();
    for (ParticleBins& bins : mScene.arriving)
        bins.take(mLeaf, mParticles, mParticleWords, mLeaving);
    mTurns.clear();
    constexpr std::uint64_t kNewestFirst = Carried::kAlone ? ~std::uint64_t(0) << Particle::kVoxelBits : 0;
    for (std::size_t i = 0; i < mParticles.size(); ++i) {
        const unsigned voxel = Domain::offset(voxelOf(toVector(mParticles[i].position)));
        mTurns.push_back({mParticles[i].id ^ kNewestFirst, std::uint32_t(i), voxel});
    }
    if (!mReleases) return; // additions commute: any order will do
    sortTurns();
    if constexpr (Carried::kAlone)
        join(); // after sorting: if the values exceed the limit, the order decides which are kept
}

/// Only the first particle in a voxel finds it open; it takes over the values of the others.
template<typename Carried>
void TileScatter<Carried>::join()
{
    constexpr std::uint32_t kNone = ~std::uint32_t(0);
    std::array<std::uint32_t, LeafVoxel::kCount> first;
    first.fill(kNone);
    mStats.blocked += std::erase_if(mTurns, [&](const Turn& turn) {
        std::uint32_t& heir = first[turn.voxel];
        if (heir == kNone) {
            heir = turn.particle;
            return false;
        }
        if constexpr (Carried::kAlone) Carried::join(mParticles[heir].alive, mParticles[turn.particle].alive);
        return true;
    });
}

/// Merge sort: particles arrive in few sorted runs, one from each neighbouring tile.
template<typename Carried>
void TileScatter<Carried>::sortTurns()
{
    const auto earlier = [](const Turn& a, const Turn& b) { return a.order < b.order; };
    mRuns.assign(1, 0);
    for (std::size_t i = 1; i < mTurns.size(); ++i) {
        if (earlier(mTurns[i], mTurns[i - 1])) mRuns.push_back(i);
    }
    mRuns.push_back(mTurns.size());
    while (mRuns.size() > 2) {
        mMerged.resize(mTurns.size());
        std::size_t kept = 0;
        for (std::size_t i = 0; i + 1 < mRuns.size(); i += 2) {
            const std::size_t middle = mRuns[i + 1], end = i + 2 < mRuns.size() ? mRuns[i + 2] : middle;
            const auto at = [&](std::size_t n) { return mTurns.begin() + std::ptrdiff_t(n); };
            std::merge(at(mRuns[i]), at(middle), at(middle), at(end), mMerged.begin() + std::ptrdiff_t(mRuns[i]),
                       earlier);
            mRuns[kept++] = mRuns[i];
        }
        mRuns[kept++] = mTurns.size();
        mRuns.resize(kept);
        mTurns.swap(mMerged);
    }
}

template<typename Carried>
template<bool kShared>
VDBLIC_INLINE void TileScatter<Carried>::advanceLive()
{
    std::array<const Turn*, kLanes> turns;
    auto turn = mTurns.begin();
    while (turn != mTurns.end()) {
        int count = 0;
        for (; turn != mTurns.end() && count < kLanes; ++turn) {
            if (Carried::kAlone && mReleases && !mOpen.isOn(turn->voxel)) {
                ++mStats.blocked;
                continue;
            }
            const Particle& particle = mParticles[turn->particle];
            mBatch.position.setLane(count, toVector(particle.position));
            mBatch.slope.setLane(count, toVector(particle.slope) * mScene.slopeScale);
            turns[std::size_t(count++)] = &*turn;
        }
        mBatch.lanes = (1u << count) - 1;
        trace();
        for (int lane = 0; lane < count; ++lane) {
            const Turn& mine = *turns[std::size_t(lane)];
            if (Carried::kAlone && mReleases && !mOpen.isOn(mine.voxel)) { // closed by a particle of this batch
                ++mStats.blocked;
                continue;
            }
            mParticle = mParticles[mine.particle];
            std::copy_n(mParticleWords.begin() + std::ptrdiff_t(mine.particle * mWordCount), mWordCount,
                        mWords.begin());
            const bool inside = scatterPath<kShared>(lane, mReleases && mCarried.mayTakeUp(mParticle, mWords.data()));
            ++mStats.particles;
            mStats.reused += mTaken > 0;
            mStats.copied += mTaken > 0 ? mTaken - 1 : 0;
            if (inside) keep(lane);
        }
    }
}

template<typename Carried>
template<bool kShared>
VDBLIC_INLINE void TileScatter<Carried>::releaseNew()
{
    const openvdb::Coord origin = mDomain.origin(mLeaf);
    const std::uint64_t firstId = mScene.step << Particle::kVoxelBits | mDomain.firstVoxelNumber(mLeaf);
    auto voxel = mDomain.mask(mLeaf).beginOn();
    while (voxel) {
        std::array<unsigned, kLanes> offsets;
        std::array<std::uint64_t, kLanes> ids;
        int count = 0;
        for (; voxel && count < kLanes; ++voxel) {
            if (!mOpen.isOn(voxel.pos())) continue;
            const openvdb::Coord at = origin + Domain::Leaf::offsetToLocalCoord(voxel.pos());
            offsets[std::size_t(count)] = voxel.pos();
            ids[std::size_t(count)] = firstId + voxel.pos();
            mBatch.position.setLane(count, Float4{float(at[0]), float(at[1]), float(at[2]), 0});
            ++count;
        }
        mBatch.lanes = (1u << count) - 1;
        mBatch.slope = mScene.field.sample(mFieldWindow, mBatch.position, Float8{}, Vector8{}, mBatch.lanes);
        trace();
        for (int lane = 0; lane < count; ++lane) {
            const unsigned offset = offsets[std::size_t(lane)];
            // A particle earlier in the batch may have closed the voxel.
            if (!mOpen.isOn(offset)) continue;
            mParticle.id = ids[std::size_t(lane)];
            mParticle.alive = mCarried.atRelease(std::uint64_t(mInput[offset]));
            std::fill(mWords.begin(), mWords.end(), 0u);
            const bool inside = scatterPath<kShared>(lane, Carried::kTakesUp);
            ++mStats.released;
            if (Carried::kTakesUp) mStats.copied += mTaken - 1;
            if (inside) keep(lane);
        }
    }
}

template<typename Carried>
template<bool kShared>
VDBLIC_INLINE void TileScatter<Carried>::runTile()
{
    const std::size_t stepsBefore = mBatch.steps;
    advanceLive<kShared>();
    if (mReleases) releaseNew<kShared>();
    mStats.steps += mBatch.steps - stepsBefore;
}

// The two kernels.
template<typename Carried>
VDBLIC_KERNEL void runShared(TileScatter<Carried>& self)
{
    self.template runTile<true>();
}
template<typename Carried>
VDBLIC_KERNEL void runAlone(TileScatter<Carried>& self)
{
    self.template runTile<false>();
}

template<typename Carried>
void TileScatter<Carried>::run(std::size_t leaf, bool shared)
{
    mLeaf = leaf;
    mWindow = LeafWindow(mDomain, mDomain.origin(leaf));
    mNextWindow = LeafWindow(mScene.next, mDomain.origin(leaf));
    mFieldWindow = mScene.field.window(mDomain.origin(leaf));
    for (std::size_t slot = 0; slot < mTarget.size(); ++slot) {
        const int there = mWindow.leaves[slot];
        mTarget[slot] = there >= 0 ? mScene.accumulator[std::size_t(there)] : outsideLeaf();
    }
    mInput = mScene.input[leaf];
    mReleases = isReleaseTurn(mDomain.origin(leaf), mScene.step, mScene.params.substeps);
    mOpen = mDomain.mask(leaf);
    takeArriving();
    shared ? runShared(*this) : runAlone(*this);
}

template class TileScatter<FadingValues>;
template class TileScatter<ValueWindow>;
template class TileScatter<SingleValue>;

} // namespace vdblic
