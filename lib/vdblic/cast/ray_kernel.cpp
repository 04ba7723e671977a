#include "vdblic/cast/ray_kernel.h"

#include "vdblic/cast/ray_cast_params.h"
#include "vdblic/cast/sample_shader.h"
#include "vdblic/cast/shade_queue.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/record_sampling.h"
#include "vdblic/volume/texture_volume.h"

#include <algorithm>
#include <limits>
#include <numbers>

namespace vdblic {
namespace {

struct Steps {
    Float8 middle, length;
};

/// The steps that samples represent, in steps from their rays' entries.
///
/// The first step is as long as the shift, the last one is what remains of the span. Samples lie in the middle of their
/// steps, so a uniform medium is integrated exactly, and shifts 0 and 1 give the same.
VDBLIC_INLINE Steps stepsOf(Int8 sample, Float8 shift, Float8 span)
{
    const Float8 after = __builtin_convertvector(sample, Float8) + shift;
    const Float8 begin = positive(after - 1), end = after < span ? after : span;
    return {(begin + end) * 0.5f, end - begin};
}

} // namespace

/// Eight rays in flight. A lane without a ray stays where nothing is visible.
struct alignas(32) RayKernel::Lanes {
    Float8 entry[3], direction[3], inverse[3];
    Float8 view[3]; // direction in world space
    Float8 shift, span;
    Float8 transmittance, halo, haloDistance; // the last two as RaySum has them
    Float8 waiting;                           // weight of samples that were too faint to be shaded
    Int8 sample, last;                        // indices of the next and of the last sample
    Int8 task;                                // index of the ray
    Int8 since;                               // the turn in which the ray began
    // Transmittance was below the limit before the sample just taken. Testing one sample late is deliberate: the newest
    // value would stall the loop.
    Int8 spent;
    Int8 blockOrigin[3], block; // block of the sample before, and its table's offset
    int turn;                   // samples that each lane has taken so far, of all its rays
    unsigned busy;              // lanes that have a ray
};

/// The lanes' samples.
struct alignas(32) RayKernel::Sample {
    Float8 distance, length; // along the ray [steps]
    Float8 position[3];      // relative to VisibleLeaves::origin(), as voxel
    Int8 voxel[3];
    Unsigned8 leaf;     // entry of VisibleLeaves
    Float8 fraction[3]; // position in the cell, 0 to 1
    Unsigned8 record;   // index of the record at the cell's lowest corner
    Float8 values[2];   // texture and driver
};

RayKernel::RayKernel(const TextureVolume& volume, const Look& look, const RayCastParams& params,
                     const VisibleLeaves& visible, const SampleShader& shader)
    : mVolume(volume), mLook(look), mVisible(visible), mShader(shader), mStep(float(params.step)),
      mPerStep(float(1 / params.step)), mLeastTransmittance(float(params.leastTransmittance))
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

/// Find the positions of the lanes' next samples, and their leaves if the samples have not left their blocks.
VDBLIC_INLINE void RayKernel::locate(const Lanes& lanes, Sample& result) const
{
    const Steps steps = stepsOf(lanes.sample, lanes.shift, lanes.span);
    result.distance = steps.middle;
    result.length = steps.length;
    const Float8 distance = steps.middle * mStep;
    for (int axis = 0; axis < 3; ++axis) {
        result.position[axis] = lanes.entry[axis] + lanes.direction[axis] * distance; // not negative
        result.voxel[axis] = __builtin_convertvector(result.position[axis] + 0.5f, Int8);
    }
    result.leaf = mVisible.findLeaves(lanes.block, result.voxel);
}

/// Negative in lanes whose ray is at its end or opaque.
VDBLIC_INLINE Int8 RayKernel::isOver(const Lanes& lanes) const
{
    return (lanes.last - lanes.sample) | lanes.spent;
}

/// The lanes whose ray is over, leaves its block, or is where nothing is visible.
VDBLIC_INLINE unsigned RayKernel::leaving(const Lanes& lanes, const Sample& sample) const
{
    const Int8 apart = (sample.voxel[0] ^ lanes.blockOrigin[0]) | (sample.voxel[1] ^ lanes.blockOrigin[1]) |
                       (sample.voxel[2] ^ lanes.blockOrigin[2]);
    const Int8 elsewhere = -Int8(Unsigned8(apart) / VisibleLeaves::kBlockDim);
    const Int8 nothing = VisibleLeaves::flagged(sample.leaf, VisibleLeaves::kNothingBit);
    return laneBits(elsewhere | nothing | isOver(lanes)) & lanes.busy;
}

/// Move lanes to the first sample behind their leaf, or behind their block if that has no visible leaf.
VDBLIC_INLINE void RayKernel::skip(Lanes& lanes, const Sample& sample, unsigned which) const
{
    // Samples at least the margin before the ray's exit are inside the box for certain.
    const Int8 dim =
        lanes.block == VisibleLeaves::kNoBlock ? broadcastInt8(VisibleLeaves::kBlockDim) : broadcastInt8(8);
    const Float8 depth = __builtin_convertvector(dim, Float8) - mMargin;
    Float8 nearest = broadcast8(std::numeric_limits<float>::infinity());
    for (int axis = 0; axis < 3; ++axis) {
        const Float8 low = __builtin_convertvector(sample.voxel[axis] & -dim, Float8) - 0.5f;
        const Float8 exit = low + (lanes.inverse[axis] > 0 ? depth : broadcast8(mMargin));
        const Float8 distance = (exit - lanes.entry[axis]) * lanes.inverse[axis];
        nearest = distance < nearest ? distance : nearest;
    }
    const Float8 last = nearest * mPerStep - lanes.shift + 0.5f;
    const Float8 end = __builtin_convertvector(lanes.last, Float8);
    const Int8 inside = __builtin_convertvector(last < end ? last : end, Int8);
    const Int8 next = (inside > lanes.sample ? inside : lanes.sample) + 1;
    lanes.sample = maskOf(which) ? next : lanes.sample;
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
    setLane(lanes.shift, lane, ray.shift);
    setLane(lanes.span, lane, ray.span);
    setLane(lanes.last, lane, ray.samples - 1);
    setLane(lanes.transmittance, lane, 1);
    for (Float8* sum : {&lanes.halo, &lanes.haloDistance, &lanes.waiting})
        setLane(*sum, lane, 0);
    setLane(lanes.sample, lane, 0);
    setLane(lanes.since, lane, lanes.turn);
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
    setLane(lanes.block, lane, VisibleLeaves::kNoBlock);
    setLane(lanes.transmittance, lane, 0);
    lanes.busy &= ~(1u << lane);
}

/// Move lanes to the next sample in a visible leaf, on their ray or, if that is over, on the next ray.
VDBLIC_KERNEL
void RayKernel::advance(const RayTask* tasks, int count, int& next, unsigned leaving, Lanes& lanes, Sample& sample,
                        RaySum* sums) const
{
    do {
        for (unsigned left = leaving & laneBits(isOver(lanes)); left != 0; left &= left - 1) {
            const int lane = __builtin_ctz(left);
            RaySum& sum = sums[lanes.task[lane]];
            sum.alpha = 1 - lanes.transmittance[lane];
            sum.halo = lanes.halo[lane];
            sum.haloDistance = lanes.haloDistance[lane];
            sum.waiting = lanes.waiting[lane];
            sum.samples = lanes.turn - lanes.since[lane];
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
            const Int8 origin = sample.voxel[axis] & -VisibleLeaves::kBlockDim;
            lanes.blockOrigin[axis] = maskOf(leaving) ? origin : lanes.blockOrigin[axis];
        }
        sample.leaf = mVisible.findLeaves(lanes.block, sample.voxel);
        leaving &= laneBits(VisibleLeaves::flagged(sample.leaf, VisibleLeaves::kNothingBit));
        if (leaving != 0) skip(lanes, sample, leaving);
    } while (leaving != 0);
}

/// Texture and driver at the lanes' samples.
VDBLIC_INLINE void RayKernel::interpolate(Sample& result) const
{
    Int8 cell[3];
    for (int axis = 0; axis < 3; ++axis) {
        cell[axis] = __builtin_convertvector(result.position[axis], Int8);
        result.fraction[axis] = result.position[axis] - __builtin_convertvector(cell[axis], Float8);
    }
    result.record = VisibleLeaves::findRecords(result.leaf, cell);
    sampleValues(mVolume.values(), result.record, result.fraction, result.values);
}

/// Those of the given lanes whose voxels are not shown.
unsigned RayKernel::findHidden(unsigned lanes, const Sample& sample) const
{
    unsigned hidden = 0;
    for (; lanes != 0; lanes &= lanes - 1) {
        const int lane = __builtin_ctz(lanes);
        const auto& [x, y, z] = sample.voxel;
        const int offset = LeafVoxel::offset(x[lane], y[lane], z[lane]);
        const bool shown = mVolume.shown(sample.record[lane] / kPaddedSize).isOn(unsigned(offset));
        hidden |= unsigned(!shown) << lane;
    }
    return hidden;
}

/// Factor on halos: 0 where a flank faces the eye, 1 where it is seen edge-on.
/// @param view directions of the rays, by axis
VDBLIC_KERNEL
void RayKernel::findFlanks(const Sample& sample, const Float8* view, Float8& result) const
{
    Float8 gradient[3];
    sampleGradients(mVolume.gradients(), sample.record, sample.fraction, gradient);
    Float8 square{}, along{};
    for (int axis = 0; axis < 3; ++axis) {
        square += gradient[axis] * gradient[axis];
        along += gradient[axis] * view[axis];
    }
    const Float8 aside = square > 0 ? 1 - along * along / square : Float8{};
    result = aside * aside;
}

/// Composite the lanes' samples, and queue those that are visible.
VDBLIC_INLINE void RayKernel::absorb(Lanes& lanes, const Sample& sample, ShadeQueue& queue) const
{
    lanes.spent = lanes.transmittance < mLeastTransmittance;
    const Int8 entries = mLook.transfer.entries(sample.values[1]);
    Float8 power;
    for (int lane = 0; lane < kLanes; ++lane)
        power[lane] = mPowers[unsigned(entries[lane])];
    const Int8 partly = VisibleLeaves::flagged(sample.leaf, VisibleLeaves::kPartlyBit);
    if (const unsigned doubtful = laneBits(partly) & lanes.busy) {
        power = maskOf(findHidden(doubtful, sample)) ? Float8{} : power;
    }
    const Float8 stretched = mLook.texture.stretched(sample.values[0]);
    const Float8 density = mLook.texture.density(stretched);
    Float8 halo{};
    if (mLook.halo.strength > 0) {
        const Float8 most = mLook.halo.density(mLook.texture, stretched);
        if (anyOf((most > 0) & (power < 0))) {
            findFlanks(sample, lanes.view, halo);
            halo *= most;
        }
    }
    const Float8 all = density + halo;
    const Float8 left = lanes.transmittance * powerOfTwo(power * all * sample.length);
    const Float8 taken = lanes.transmittance - left;
    lanes.transmittance = left;
    Float8 weight = taken;
    if (mLook.halo.strength > 0) {
        weight = all > 0 ? taken * density / all : Float8{};
        lanes.halo += taken - weight;
        lanes.haloDistance += (taken - weight) * sample.distance;
    }

    // Faint samples wait for further ones of their ray.
    weight += lanes.waiting;
    const Int8 enough = weight > (1 - left) * mLeastTransmittance;
    lanes.waiting = enough ? Float8{} : weight;
    queue.push({.fraction = {sample.fraction[0], sample.fraction[1], sample.fraction[2]},
                .record = sample.record,
                .task = lanes.task,
                .distance = sample.distance,
                .weight = weight,
                .stretched = stretched,
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
        interpolate(sample);
        absorb(lanes, sample, queue);
        lanes.sample += 1;
        ++lanes.turn;
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
