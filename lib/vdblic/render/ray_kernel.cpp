#include "vdblic/render/ray_kernel.h"

#include "vdblic/render/record_sampling.h"

#include <numbers>

namespace vdblic {
namespace {

struct SamplePlaces {
    Float8 place, length;
};

/// Where a ray's sample lies and how much of the ray it stands for, in steps.
///
/// The span is cut into steps, the first of which is as long as the shift says and the last as is left; samples lie in
/// their middles. So a uniform medium is integrated exactly, and shifts 0 and 1 are the same.
VDBLIC_INLINE SamplePlaces samplePlace(Int8 sample, Float8 shift, Float8 span)
{
    const Float8 after = __builtin_convertvector(sample, Float8) + shift;
    const Float8 begin = positive(after - 1), end = after < span ? after : span;
    return {(begin + end) * 0.5f, end - begin};
}

} // namespace

/// Eight rays under way. A lane without a ray stands still where there is nothing.
struct alignas(32) RayKernel::Lanes {
    Float8 entry[3], direction[3], inverse[3];
    Float8 view[3]; // direction in world space
    Float8 shift, span;
    Float8 transmittance, halo, haloPlace;
    Float8 waiting;          // the weight of samples that added too little to be shaded
    Int8 sample, last, task; // of the samples, the next and the last
    Int8 since;              // the turn with which the ray began
    Int8 spent; // too little light was left before the last sample; that after it would have to be waited for
    Int8 blockOrigin[3], block; // where they are, as VisibleLeaves has them
    int turn;                   // how many samples each has taken, rays after each other
    unsigned busy;              // lanes that have a ray
};

/// The lanes' samples: where they lie and what they meet there.
struct alignas(32) RayKernel::Sample {
    Float8 place, length; // along the ray [steps]
    Float8 position[3];
    Int8 voxel[3];
    Unsigned8 leaf;     // the entry of VisibleLeaves
    Float8 fraction[3]; // in the cell
    Unsigned8 record;   // number of the record at the cell's lowest corner
    Float8 values[2];   // texture and magnitude
};

RayKernel::RayKernel(const TextureVolume& volume, const Look& look, const RayCastParams& params,
                     const VisibleLeaves& visible, const SampleShader& shader)
    : mVolume(volume), mLook(look), mVisible(visible), mShader(shader), mStep(float(params.step)),
      mPerStep(float(1 / params.step)), mLeastTransmittance(float(params.leastTransmittance))
{
    mPowers.assign(look.transfer.extinctions(), look.transfer.extinctions() + TransferFunction::kEntries);
    for (float& power : mPowers)
        power *= -mStep * std::numbers::log2e_v<float>;
    // More than single precision can be wrong by, in voxels, when it says where a ray leaves a box.
    double reach = 0;
    for (int axis = 0; axis < 3; ++axis)
        reach = std::max(reach, volume.high()[axis] - visible.first()[axis]);
    mMargin = float(1e-5 + reach * 0x1p-20);
}

/// Find where the lanes' next samples lie, and in which leaves if it is in the same blocks as the last ones.
VDBLIC_INLINE void RayKernel::place(const Lanes& lanes, Sample& result) const
{
    const SamplePlaces sample = samplePlace(lanes.sample, lanes.shift, lanes.span);
    result.place = sample.place;
    result.length = sample.length;
    const Float8 distance = sample.place * mStep;
    for (int axis = 0; axis < 3; ++axis) {
        result.position[axis] = lanes.entry[axis] + lanes.direction[axis] * distance; // not negative
        result.voxel[axis] = __builtin_convertvector(result.position[axis] + 0.5f, Int8);
    }
    result.leaf = mVisible.findLeaves(lanes.block, result.voxel);
}

/// Negative in the lanes whose ray is at its end, or has no light left to take.
VDBLIC_INLINE Int8 RayKernel::isOver(const Lanes& lanes) const
{
    return (lanes.last - lanes.sample) | lanes.spent;
}

/// The lanes whose ray is over or leaves its block, or is where nothing is visible.
VDBLIC_INLINE unsigned RayKernel::leaving(const Lanes& lanes, const Sample& sample) const
{
    const Int8 apart = (sample.voxel[0] ^ lanes.blockOrigin[0]) | (sample.voxel[1] ^ lanes.blockOrigin[1]) |
                       (sample.voxel[2] ^ lanes.blockOrigin[2]);
    const Int8 elsewhere = -Int8(Unsigned8(apart) / VisibleLeaves::kBlockDim);
    const Int8 nothing = VisibleLeaves::flagged(sample.leaf, VisibleLeaves::kNothingBit);
    return laneBits(elsewhere | nothing | isOver(lanes)) & lanes.busy;
}

/// Take lanes to the first sample behind the leaf or the block they are in.
VDBLIC_INLINE void RayKernel::skip(Lanes& lanes, const Sample& sample, unsigned which) const
{
    // The samples before the ray comes within the margin of leaving this box are surely inside.
    const Int8 dim =
        lanes.block == VisibleLeaves::kNoBlock ? broadcastInt8(VisibleLeaves::kBlockDim) : broadcastInt8(8);
    const Float8 depth = __builtin_convertvector(dim, Float8) - mMargin;
    Float8 nearest = broadcast8(std::numeric_limits<float>::infinity());
    for (int axis = 0; axis < 3; ++axis) {
        const Float8 low = __builtin_convertvector(sample.voxel[axis] & -dim, Float8) - 0.5f;
        const Float8 exit = low + (lanes.inverse[axis] > 0 ? depth : broadcast8(mMargin));
        const Float8 there = (exit - lanes.entry[axis]) * lanes.inverse[axis];
        nearest = there < nearest ? there : nearest;
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
    for (Float8* sum : {&lanes.halo, &lanes.haloPlace, &lanes.waiting})
        setLane(*sum, lane, 0);
    setLane(lanes.sample, lane, 0);
    setLane(lanes.since, lane, lanes.turn);
    setLane(lanes.spent, lane, 0);
    setLane(lanes.task, lane, task);
    lanes.busy |= 1u << lane;
}

/// Let a lane stand still, where no light is left to take.
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

/// Take lanes to the next sample in a visible leaf, on their ray or, if that is over, on the next ray.
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
            sum.haloPlace = lanes.haloPlace[lane];
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
        place(lanes, sample);
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

/// Texture and magnitude at the lanes' samples.
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

/// Those of some lanes whose voxels are not shown.
unsigned RayKernel::findHidden(unsigned lanes, const Sample& sample) const
{
    unsigned hidden = 0;
    for (; lanes != 0; lanes &= lanes - 1) {
        const int lane = __builtin_ctz(lanes);
        const auto& [x, y, z] = sample.voxel;
        const int offset = LeafVoxel::offset(x[lane], y[lane], z[lane]);
        const bool shown = mVolume.shown(sample.record[lane] / kBrickSize).isOn(unsigned(offset));
        hidden |= unsigned(!shown) << lane;
    }
    return hidden;
}

/// How far the flanks at the samples are turned aside: of halos, the share that is left.
/// @param view by axis
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

/// Let the lanes' samples take their part of the light, and queue those that are seen.
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
        lanes.haloPlace += (taken - weight) * sample.place;
    }

    // What adds next to nothing to its ray waits for more.
    weight += lanes.waiting;
    const Int8 enough = weight > (1 - left) * mLeastTransmittance;
    lanes.waiting = enough ? Float8{} : weight;
    const unsigned seen = laneBits(enough);
    const Int8 order = kPacking[seen];
    const int end = queue.end;
    for (int axis = 0; axis < 3; ++axis)
        queue.put(queue.fraction[axis] + end, sample.fraction[axis], order);
    queue.put(queue.record + end, sample.record, order);
    queue.put(queue.task + end, lanes.task, order);
    queue.put(queue.place + end, sample.place, order);
    queue.put(queue.weight + end, weight, order);
    queue.put(queue.stretched + end, stretched, order);
    queue.put(queue.entry + end, entries, order);
    queue.end = end + __builtin_popcount(seen);
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
        place(lanes, sample);
        if (const unsigned left = leaving(lanes, sample)) advance(tasks, count, next, left, lanes, sample, sums);
        if (lanes.busy == 0) break;
        interpolate(sample);
        absorb(lanes, sample, queue);
        lanes.sample += 1;
        ++lanes.turn;
        if (queue.end >= ShadeQueue::kMany) {
            for (; queue.begin + kLanes <= queue.end; queue.begin += kLanes)
                mShader.shade(queue, tasks, sums);
            queue.compact();
        }
    }
    while (queue.begin < queue.end) {
        for (int i = queue.end; i < queue.begin + kLanes; ++i) {
            queue.weight[i] = 0;
            queue.record[i] = 0;
            queue.task[i] = 0;
            queue.entry[i] = 0;
            queue.place[i] = queue.stretched[i] = 0;
            for (float* fraction : queue.fraction)
                fraction[i] = 0;
        }
        mShader.shade(queue, tasks, sums);
        queue.begin += kLanes;
    }
}

} // namespace vdblic
