#include "vdblic/cast/ray_kernel.h"

#include "vdblic/cast/ray_cast_params.h"
#include "vdblic/cast/sample_shader.h"
#include "vdblic/cast/shade_queue.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/texture_volume.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace vdblic {
namespace {

constexpr int kEnoughLanes = 3;
constexpr float kMostBack = 0.499f; // voxels, from a sample to the place of its scalar, gradient and light

/// The middles of steps, in steps from their rays' entries.
///
/// The first step is as long as the shift, the last one ends with the span.
VDBLIC_INLINE Float8 middleOf(Int8 step, Float8 shift, Float8 span)
{
    const Float8 after = __builtin_convertvector(step, Float8) + shift;
    const Float8 begin = positive(after - 1), end = after < span ? after : span;
    return (begin + end) * 0.5f;
}

} // namespace

/// Eight rays in flight. A lane without a ray stays where nothing is visible.
struct alignas(32) RayKernel::Lanes {
    Float8 entry[3], direction[3], inverse[3];
    Float8 view[3]; // direction in world space
    Float8 reach;   // steps in which a ray moves a voxel along the axis where it moves fastest
    Float8 shift, span;
    Float8 before;                            // stretched texture at the sample before; negative: there is none
    Float8 transmittance, halo, haloDistance; // the last two as RaySum has them
    Float8 waiting;                           // weight of samples that were too faint to be shaded
    Int8 sample, last;                        // indices of the next and of the last sample
    Int8 task;                                // index of the ray
    Int8 taken;                               // samples of the ray so far
    // Transmittance was below the limit before the newest sample. Testing one sample late is deliberate: the newest
    // value would stall the loop.
    Int8 spent;
    Int8 blockOrigin[3], block; // block of the sample before, and its table's offset
    unsigned busy;              // lanes that have a ray
};

/// The lanes' samples.
struct alignas(32) RayKernel::Sample {
    Int8 index;      // of the sample on its ray
    Float8 distance; // along the ray [steps]
    Int8 voxel[3];   // relative to VisibleSpace::origin()
    Cells cells;     // relative to the first voxels of their leaves
    Unsigned8 entry; // of the leaf in VisibleSpace
    Int8 distant;    // distance of the cell from the nearest visible cell
    Unsigned8 leaf;  // number
    Float8 texture;
    CornerTextures corners; // unless interpolation is cubic
};

RayKernel::RayKernel(const TextureVolume& volume, const Look& look, const RayCastParams& params,
                     const VisibleSpace& visible, const SampleShader& shader)
    : mVolume(volume), mTexture(volume.texture()), mLook(look), mVisible(visible), mShader(shader),
      mStep(float(params.step)), mPerStep(float(1 / params.step)),
      mLeastTransmittance(float(params.leastTransmittance)), mHidden(std::max(look.hiddenStretched(), 0.0f)),
      mIsCubic(params.isCubic())
{
    mPowers.assign(look.transfer.extinctions(), look.transfer.extinctions() + TransferFunction::kEntries);
    for (float& power : mPowers)
        power *= -mStep * std::numbers::log2e_v<float>;
    // Bound on the error in single precision of the distance at which a ray leaves a box [voxels].
    double reach = 0;
    for (int axis = 0; axis < 3; ++axis)
        reach = std::max(reach, volume.high()[axis] - visible.origin()[axis]);
    mMargin = float(1e-5 + reach * 0x1p-20);
}

/// Find the positions of the lanes' next samples and, for samples still in their blocks, the distance to the nearest
/// visible cell.
VDBLIC_INLINE void RayKernel::locate(const Lanes& lanes, Sample& result) const
{
    result.index = lanes.sample;
    result.distance = middleOf(lanes.sample, lanes.shift, lanes.span);
    const Float8 distance = result.distance * mStep;
    for (int axis = 0; axis < 3; ++axis) {
        const Float8 position = lanes.entry[axis] + lanes.direction[axis] * distance; // not negative
        const Int8 cell = __builtin_convertvector(position, Int8);
        result.voxel[axis] = __builtin_convertvector(position + 0.5f, Int8);
        result.cells.low[axis] = cell - (result.voxel[axis] & -LeafVoxel::kDim);
        result.cells.fraction[axis] = position - __builtin_convertvector(cell, Float8);
    }
    findEmpty(lanes, result);
}

/// Find the lanes' distances from visible cells.
VDBLIC_INLINE void RayKernel::findEmpty(const Lanes& lanes, Sample& result) const
{
    result.entry = mVisible.findLeaves(lanes.block, result.voxel);
    result.distant = mVisible.findDistances(result.entry, result.cells.low);
}

/// Negative in lanes whose ray is at its end or opaque.
VDBLIC_INLINE Int8 RayKernel::isOver(const Lanes& lanes) const
{
    return (lanes.last - lanes.sample) | lanes.spent;
}

/// The lanes whose ray is over or leaves its block.
VDBLIC_INLINE unsigned RayKernel::leaving(const Lanes& lanes, const Sample& sample) const
{
    const Int8 apart = (sample.voxel[0] ^ lanes.blockOrigin[0]) | (sample.voxel[1] ^ lanes.blockOrigin[1]) |
                       (sample.voxel[2] ^ lanes.blockOrigin[2]);
    const Int8 elsewhere = -Int8(Unsigned8(apart) / VisibleSpace::kBlockDim);
    return laneBits(elsewhere | isOver(lanes)) & lanes.busy;
}

/// Move lanes to the next sample that may lie in a visible cell. @param which lanes whose samples do not
VDBLIC_INLINE void RayKernel::skip(Lanes& lanes, const Sample& sample, unsigned which) const
{
    // The samples on the way lie less than so many voxels from this one, along each axis.
    const Float8 nearby = __builtin_convertvector(sample.distant - 1, Float8) * lanes.reach;
    Int8 next = sample.index + __builtin_convertvector(nearby, Int8) + 1;
    const Int8 nothing = VisibleSpace::flagged(sample.entry, VisibleSpace::kNothingBit);
    if ((laneBits(nothing) & which) != 0) skipLeaves(lanes, sample, next);
    lanes.sample = maskOf(which) ? next : lanes.sample;
    lanes.before = maskOf(which) ? broadcast8(mHidden) : lanes.before;
}

/// The first sample behind the leaf and the empty space around it, or behind the block, of lanes that have no visible
/// leaf.
VDBLIC_KERNEL
void RayKernel::skipLeaves(const Lanes& lanes, const Sample& sample, Int8& next) const
{
    const Int8 isNowhere = lanes.block == VisibleSpace::kNoBlock;
    Float8 nearest = broadcast8(std::numeric_limits<float>::infinity());
    for (int axis = 0; axis < 3; ++axis) {
        const Int8 leaf = sample.voxel[axis] & -LeafVoxel::kDim, block = sample.voxel[axis] & -VisibleSpace::kBlockDim;
        // The outermost cells may be visible in the next leaf: at a distance of 1 only the leaf's voxels are empty.
        const Float8 low = __builtin_convertvector(leaf - sample.distant, Float8) + 0.5f;
        const Float8 high = __builtin_convertvector(leaf + LeafVoxel::kDim - 1 + sample.distant, Float8) - 0.5f;
        const Float8 least = __builtin_convertvector(block, Float8) - 0.5f, most = least + VisibleSpace::kBlockDim;
        // Samples at least the margin before the ray's exit are inside for certain.
        const Float8 exit = lanes.inverse[axis] > 0 ? ((isNowhere | (high > most)) ? most : high) - mMargin
                                                    : ((isNowhere | (low < least)) ? least : low) + mMargin;
        const Float8 distance = (exit - lanes.entry[axis]) * lanes.inverse[axis];
        nearest = distance < nearest ? distance : nearest;
    }
    const Float8 last = nearest * mPerStep - lanes.shift + 0.5f;
    const Float8 end = __builtin_convertvector(lanes.last, Float8);
    const Int8 inside = __builtin_convertvector(last < end ? last : end, Int8);
    const Int8 nothing = VisibleSpace::flagged(sample.entry, VisibleSpace::kNothingBit);
    next = nothing < 0 ? (inside > sample.index ? inside : sample.index) + 1 : next;
}

/// Give a lane a ray.
VDBLIC_INLINE void RayKernel::load(const RayTask& ray, int task, Lanes& lanes, int lane) const
{
    for (int axis = 0; axis < 3; ++axis) {
        setLane(lanes.entry[axis], lane, ray.entry[axis]);
        setLane(lanes.direction[axis], lane, ray.direction[axis]);
        setLane(lanes.inverse[axis], lane, ray.inverse[axis]);
        setLane(lanes.view[axis], lane, ray.shading[kViewX + axis]);
    }
    float slowest = std::abs(ray.inverse[0]);
    for (int axis = 1; axis < 3; ++axis)
        slowest = std::min(slowest, std::abs(ray.inverse[axis]));
    setLane(lanes.reach, lane, slowest * mPerStep * (1 - 0x1p-16f));
    setLane(lanes.shift, lane, ray.shift);
    setLane(lanes.span, lane, ray.span);
    setLane(lanes.before, lane, -1);
    setLane(lanes.last, lane, ray.samples - 1);
    setLane(lanes.transmittance, lane, 1);
    for (Float8* sum : {&lanes.halo, &lanes.haloDistance, &lanes.waiting})
        setLane(*sum, lane, 0);
    setLane(lanes.sample, lane, 0);
    setLane(lanes.taken, lane, 0);
    setLane(lanes.spent, lane, 0);
    setLane(lanes.task, lane, task);
    lanes.busy |= 1u << lane;
}

/// Take a lane's ray away.
VDBLIC_INLINE void RayKernel::park(Lanes& lanes, int lane) const
{
    for (int axis = 0; axis < 3; ++axis) {
        setLane(lanes.entry[axis], lane, 0);
        setLane(lanes.direction[axis], lane, 0);
    }
    setLane(lanes.block, lane, VisibleSpace::kNoBlock);
    setLane(lanes.transmittance, lane, 0);
    lanes.busy &= ~(1u << lane);
}

/// Give lanes whose ray is over the next ray, and find the blocks of all lanes that are leaving.
VDBLIC_KERNEL
void RayKernel::advance(const RayTask* tasks, int count, int& next, unsigned leaving, Lanes& lanes, Sample& sample,
                        RaySum* sums) const
{
    for (unsigned left = leaving & laneBits(isOver(lanes)); left != 0; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        RaySum& sum = sums[lanes.task[lane]];
        sum.alpha = 1 - lanes.transmittance[lane];
        sum.halo = lanes.halo[lane];
        sum.haloDistance = lanes.haloDistance[lane];
        sum.waiting = lanes.waiting[lane];
        sum.samples = lanes.taken[lane];
        if (next < count) {
            load(tasks[next], next, lanes, lane);
            ++next;
        } else {
            park(lanes, lane);
            leaving &= ~(1u << lane);
        }
    }
    locate(lanes, sample);
    for (unsigned left = leaving; left != 0; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        const auto& [x, y, z] = sample.voxel;
        setLane(lanes.block, lane, mVisible.findBlock(x[lane], y[lane], z[lane]));
    }
    for (int axis = 0; axis < 3; ++axis) {
        const Int8 origin = sample.voxel[axis] & -VisibleSpace::kBlockDim;
        lanes.blockOrigin[axis] = maskOf(leaving) ? origin : lanes.blockOrigin[axis];
    }
    findEmpty(lanes, sample);
}

/// The texture at the samples, at least of the given lanes.
VDBLIC_INLINE void RayKernel::interpolate(Sample& result, unsigned which) const
{
    result.leaf = VisibleSpace::leafOf(result.entry);
    if (mIsCubic) {
        interpolateCubic(result, which);
    } else {
        result.corners = mTexture.corners(result.leaf, result.cells);
        result.texture = result.corners.at(result.cells.fraction);
    }
}

VDBLIC_KERNEL
void RayKernel::interpolateCubic(Sample& result, unsigned which) const
{
    result.texture = mTexture.cubicAt(result.leaf, result.cells, which);
}

/// The given lanes whose voxels are hidden.
unsigned RayKernel::findHidden(unsigned lanes, const Sample& sample) const
{
    unsigned hidden = 0;
    for (; lanes != 0; lanes &= lanes - 1) {
        const int lane = __builtin_ctz(lanes);
        const auto& [x, y, z] = sample.voxel;
        const int offset = LeafVoxel::offset(x[lane], y[lane], z[lane]);
        const bool shown = mVolume.shown(sample.leaf[lane]).isOn(unsigned(offset));
        hidden |= unsigned(!shown) << lane;
    }
    return hidden;
}

/// Factor on halos: 0 where a flank faces the eye, 1 where it is seen edge-on.
/// @param view directions of the rays, by axis
VDBLIC_INLINE void RayKernel::findFlanks(const Sample& sample, const Float8* view, Float8& result) const
{
    Float8 slopes[3];
    const CornerTextures corners = mIsCubic ? mTexture.corners(sample.leaf, sample.cells) : sample.corners;
    corners.slopes(sample.cells.fraction, slopes);
    const glm::mat3& toWorld = mVolume.gradientToWorld();
    Float8 square{}, along{};
    for (int axis = 0; axis < 3; ++axis) {
        const Float8 gradient =
            toWorld[0][axis] * slopes[0] + toWorld[1][axis] * slopes[1] + toWorld[2][axis] * slopes[2];
        square += gradient * gradient;
        along += gradient * view[axis];
    }
    result = square > 0 ? Halo::edge(along * along / square) : Float8{};
}

/// Composite the steps between the given lanes' samples and the ones before, and queue the visible samples.
///
/// The texture changes evenly between two samples; everything else has its value in the middle, or half a voxel before
/// the later sample where steps are longer than a voxel. A ray's first and last sample stand for the parts before and
/// behind them, too.
VDBLIC_INLINE void RayKernel::absorb(Lanes& lanes, Int8 which, const Sample& sample, ShadeQueue& queue) const
{
    // Of these lanes alone: a picture must not depend on a ray's neighbours.
    lanes.spent = which ? lanes.transmittance < mLeastTransmittance : lanes.spent;
    // Empty space has at most the largest texture without opacity.
    const Int8 isEmpty = sample.distant > 0;
    const Float8 stretched = isEmpty ? broadcast8(mHidden) : mLook.texture.stretched(sample.texture);
    const Float8 before = lanes.before < 0 ? stretched : lanes.before;
    lanes.before = which ? stretched : lanes.before;
    const Float8 density = mLook.texture.meanDensity(before, stretched), texture = (before + stretched) * 0.5f;
    Float8 halo{};
    if (mLook.halo.strength > 0) halo = mLook.halo.density(mLook.texture, texture);
    if (!anyOf((density + halo > 0) & which)) return;

    const Float8 previous = sample.index > 0 ? middleOf(sample.index - 1, lanes.shift, lanes.span) : Float8{};
    const Float8 end = sample.index < lanes.last ? sample.distance : lanes.span;
    // A sample's leaf holds values up to half a voxel before it, no more.
    const Float8 half = (sample.distance - previous) * 0.5f, most = broadcast8(kMostBack * mPerStep);
    const Float8 distance = sample.distance - (half < most ? half : most), back = (distance - sample.distance) * mStep;
    Float8 place[3]; // relative to the first voxels of their leaves
    for (int axis = 0; axis < 3; ++axis)
        place[axis] = sample.cells.position(axis) + lanes.direction[axis] * back;
    const Int8 entries = mLook.transfer.entries(mVolume.drivers().at(sample.leaf, place));
    Float8 power;
    for (int lane = 0; lane < kLanes; ++lane)
        power[lane] = mPowers[unsigned(entries[lane])];
    const Int8 hasRecords = VisibleSpace::flagged(sample.entry, VisibleSpace::kNothingBit) >= 0;
    power = which & hasRecords ? power : Float8{};
    const Int8 partly = VisibleSpace::flagged(sample.entry, VisibleSpace::kPartlyBit) & hasRecords;
    if (const unsigned doubtful = laneBits(partly & which)) {
        power = maskOf(findHidden(doubtful, sample)) ? Float8{} : power;
    }
    if (anyOf((halo > 0) & (power < 0))) {
        Float8 flank;
        findFlanks(sample, lanes.view, flank);
        halo *= flank;
    }
    const Float8 all = density + halo;
    const Float8 left = lanes.transmittance * powerOfTwo(power * all * (end - previous));
    const Float8 taken = lanes.transmittance - left;
    lanes.transmittance = left;
    Float8 weight = taken;
    if (mLook.halo.strength > 0) {
        weight = all > 0 ? taken * density / all : Float8{};
        lanes.halo += taken - weight;
        lanes.haloDistance += (taken - weight) * distance;
    }

    // Faint samples wait for further ones of their ray.
    weight += lanes.waiting;
    const Int8 enough = weight > (1 - left) * mLeastTransmittance;
    lanes.waiting = enough ? Float8{} : weight;
    queue.push({.position = {place[0], place[1], place[2]},
                .leaf = sample.leaf,
                .task = lanes.task,
                .distance = distance,
                .weight = weight,
                .stretched = texture,
                .entry = entries},
               laneBits(enough));
}

VDBLIC_KERNEL
void RayKernel::trace(const RayTask* tasks, int count, RaySum* sums) const
{
    Lanes lanes{};
    for (Int8& origin : lanes.blockOrigin)
        origin = broadcastInt8(1 << 30); // of no block
    int next = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
        if (next < count) {
            load(tasks[next], next, lanes, lane);
            ++next;
        } else {
            park(lanes, lane);
        }
    }
    ShadeQueue queue;
    Sample sample;
    while (true) {
        locate(lanes, sample);
        if (const unsigned left = leaving(lanes, sample)) advance(tasks, count, next, left, lanes, sample, sums);
        if (lanes.busy == 0) break;
        // A ray takes one sample more behind the last visible cell.
        const Int8 isBehind = lanes.before > mHidden;
        const unsigned empty = laneBits(-sample.distant & ~isBehind) & lanes.busy, seen = lanes.busy & ~empty;
        if (empty != 0) {
            skip(lanes, sample, empty);
            // A sample costs more than a skip: most lanes should have one.
            if (__builtin_popcount(seen) < kEnoughLanes) continue;
        }
        interpolate(sample, seen);
        const Int8 isSeen = maskOf(seen);
        absorb(lanes, isSeen, sample, queue);
        lanes.sample -= isSeen;
        lanes.taken -= isSeen;
        if (queue.isFull()) {
            for (; queue.hasEight(); queue.pop())
                mShader.shade(queue, tasks, sums);
            queue.compact();
        }
    }
    for (; !queue.empty(); queue.pop()) {
        queue.fillUp();
        mShader.shade(queue, tasks, sums);
    }
}

} // namespace vdblic
