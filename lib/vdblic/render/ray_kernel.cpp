#include "vdblic/render/ray_kernel.h"

#include "vdblic/render/record_sampling.h"

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

/// The cells of two lanes side by side: values at a corner and its neighbour along z, of the one and of the other.
VDBLIC_INLINE Float8 loadPairs(const ValueRecord* a, const ValueRecord* b)
{
    Float4 first, second;
    std::memcpy(&first, a, sizeof first);
    std::memcpy(&second, b, sizeof second);
    return __builtin_shufflevector(first, second, 0, 1, 2, 3, 4, 5, 6, 7);
}

/// Lane i of eight, four times, and lane i + 4, four times.
template<int i>
VDBLIC_INLINE Float8 spread(Float8 x)
{
    return __builtin_shufflevector(x, x, i, i, i, i, i + 4, i + 4, i + 4, i + 4);
}

} // namespace

/// Eight rays under way. A lane without a ray stands still where there is nothing.
struct alignas(32) RayKernel::Lanes {
    Float8 entry[3], direction[3], inverse[3];
    Float8 view[3]; // direction in world space
    Float8 shift, span;
    Float8 transmittance, halo, haloPlace;
    Float8 waiting; // the weight of samples that added too little to be shaded
    Int8 samples, sample, taken, task;
    Int8 spent; // too little light was left before the last sample; that after it would have to be waited for
    Int8 blockOrigin[3], block; // where they are, as VisibleLeaves has them
    unsigned busy;              // lanes that have a ray
};

/// The lanes' samples: where they lie and what they meet there.
struct alignas(32) RayKernel::Sample {
    Float8 place, length; // along the ray [steps]
    Float8 position[3];
    Int8 voxel[3];
    Unsigned8 leaf;     // the entry of VisibleLeaves
    Float8 fraction[3]; // in the cell
    Int8 record;        // number of the record at the cell's lowest corner
    Float8 texture, magnitude;
    unsigned hidden; // lanes whose voxel is not shown
};

RayKernel::RayKernel(const TextureVolume& volume, const Look& look, const RayCastParams& params,
                     const VisibleLeaves& visible, const SampleShader& shader)
    : mVolume(volume), mLook(look), mVisible(visible), mShader(shader), mStep(float(params.step)),
      mPerStep(float(1 / params.step)), mLeastTransmittance(float(params.leastTransmittance))
{
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

/// The lanes whose ray is at its end, or has no light left to take.
VDBLIC_INLINE Int8 RayKernel::isOver(const Lanes& lanes) const
{
    return (lanes.sample >= lanes.samples) | lanes.spent;
}

/// The lanes whose ray is over or leaves its block, or is where nothing is visible.
VDBLIC_INLINE unsigned RayKernel::leaving(const Lanes& lanes, const Sample& sample) const
{
    const Int8 apart = (sample.voxel[0] ^ lanes.blockOrigin[0]) | (sample.voxel[1] ^ lanes.blockOrigin[1]) |
                       (sample.voxel[2] ^ lanes.blockOrigin[2]);
    const Int8 here = (apart & -VisibleLeaves::kBlockDim) | Int8(sample.leaf & VisibleLeaves::kNothing);
    return laneBits((here != 0) | isOver(lanes)) & lanes.busy;
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
    const Float8 all = __builtin_convertvector(lanes.samples, Float8);
    const Int8 inside = __builtin_convertvector(last < all ? last : all, Int8);
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
    setLane(lanes.samples, lane, ray.samples);
    setLane(lanes.transmittance, lane, 1);
    for (Float8* sum : {&lanes.halo, &lanes.haloPlace, &lanes.waiting})
        setLane(*sum, lane, 0);
    setLane(lanes.sample, lane, 0);
    setLane(lanes.taken, lane, 0);
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
    setLane(lanes.transmittance, lane, 0);
    lanes.busy &= ~(1u << lane);
}

/// Take lanes to the next sample in a visible leaf, on their ray or, if that is over, on the next ray.
VDBLIC_INLINE void RayKernel::advance(const RayTask* tasks, int count, int& next, unsigned leaving, Lanes& lanes,
                                      Sample& sample, RaySum* sums) const
{
    do {
        for (unsigned left = leaving & laneBits(isOver(lanes)); left != 0; left &= left - 1) {
            const int lane = __builtin_ctz(left);
            RaySum& sum = sums[lanes.task[lane]];
            sum.alpha = 1 - lanes.transmittance[lane];
            sum.halo = lanes.halo[lane];
            sum.haloPlace = lanes.haloPlace[lane];
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
        leaving &= laneBits((sample.leaf & VisibleLeaves::kNothing) != 0);
        if (leaving != 0) skip(lanes, sample, leaving);
    } while (leaving != 0);
}

/// Texture and magnitude at the lanes' samples.
VDBLIC_INLINE void RayKernel::interpolate(Sample& result) const
{
    Int8 cell[3]; // in the leaf; from −1 on
    for (int axis = 0; axis < 3; ++axis) {
        const Int8 base = __builtin_convertvector(result.position[axis], Int8);
        result.fraction[axis] = result.position[axis] - __builtin_convertvector(base, Float8);
        cell[axis] = base - (result.voxel[axis] & -8);
    }
    result.record = Int8(result.leaf & ~VisibleLeaves::kFlags) + brickIndex(cell[0], cell[1], cell[2]);

    const ValueRecord* records = mVolume.values();
    constexpr int kY = kBrickDim, kX = kBrickDim * kBrickDim;
    const auto both = [&](Float8 x, Float8 y, Float8 z, unsigned a, unsigned b) {
        const auto mix = [](Float8 from, Float8 to, Float8 t) { return from + (to - from) * t; };
        const auto pairs = [&](int i) { return loadPairs(records + a + i, records + b + i); };
        const Float8 across = mix(mix(pairs(0), pairs(kY), y), mix(pairs(kX), pairs(kX + kY), y), x);
        return mix(across, __builtin_shufflevector(across, across, 2, 3, 2, 3, 6, 7, 6, 7), z);
    };
    const auto& [x, y, z] = result.fraction;
    const Int8& record = result.record;
    const Float8 values[] = {both(spread<0>(x), spread<0>(y), spread<0>(z), unsigned(record[0]), unsigned(record[4])),
                             both(spread<1>(x), spread<1>(y), spread<1>(z), unsigned(record[1]), unsigned(record[5])),
                             both(spread<2>(x), spread<2>(y), spread<2>(z), unsigned(record[2]), unsigned(record[6])),
                             both(spread<3>(x), spread<3>(y), spread<3>(z), unsigned(record[3]), unsigned(record[7]))};
    const Float8 front = __builtin_shufflevector(values[0], values[1], 0, 8, 1, 9, 4, 12, 5, 13);
    const Float8 back = __builtin_shufflevector(values[2], values[3], 0, 8, 1, 9, 4, 12, 5, 13);
    result.texture = __builtin_shufflevector(front, back, 0, 1, 8, 9, 4, 5, 12, 13);
    result.magnitude = __builtin_shufflevector(front, back, 2, 3, 10, 11, 6, 7, 14, 15);

    result.hidden = 0;
    const Int8 offsets = (result.voxel[0] & 7) << 6 | (result.voxel[1] & 7) << 3 | (result.voxel[2] & 7);
    for (unsigned left = laneBits((result.leaf & VisibleLeaves::kPartly) != 0); left != 0; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        const bool shown = mVolume.shown(result.leaf[lane] / kBrickSize).isOn(unsigned(offsets[lane]));
        result.hidden |= unsigned(!shown) << lane;
    }
}

/// The share of the extinction that halos add.
VDBLIC_INLINE Float8 RayKernel::haloShare(const Lanes& lanes, const Sample& sample, Float8 stretched) const
{
    const Float8 density = mLook.halo.density(mLook.texture, stretched);
    if (!anyOf(density > 0)) return density;
    unsigned record[kLanes];
    float place[3][kLanes];
    std::memcpy(record, &sample.record, sizeof record);
    std::memcpy(place, sample.fraction, sizeof place);
    Float8 gradient[3];
    sampleGradients(mVolume.gradients(), record, place[0], place[1], place[2], gradient);
    Float8 square{}, along{};
    for (int axis = 0; axis < 3; ++axis) {
        square += gradient[axis] * gradient[axis];
        along += gradient[axis] * lanes.view[axis];
    }
    const Float8 aside = square > 0 ? 1 - along * along / square : Float8{};
    return density * aside * aside;
}

/// Let the lanes' samples take their part of the light, and queue those that are seen.
VDBLIC_INLINE void RayKernel::absorb(Lanes& lanes, const Sample& sample, ShadeQueue& queue) const
{
    lanes.spent = lanes.transmittance < mLeastTransmittance;
    const Int8 entries = mLook.transfer.entries(sample.magnitude);
    const float* extinctions = mLook.transfer.extinctions();
    Float8 extinction;
    for (int lane = 0; lane < kLanes; ++lane)
        extinction[lane] = extinctions[unsigned(entries[lane])];
    if (sample.hidden != 0) {
        for (int lane = 0; lane < kLanes; ++lane)
            extinction[lane] = sample.hidden >> lane & 1 ? 0 : extinction[lane];
    }
    const Float8 stretched = mLook.texture.stretched(sample.texture);
    const Float8 density = mLook.texture.density(stretched);
    const Float8 halo = mLook.halo.strength > 0 ? haloShare(lanes, sample, stretched) : Float8{};
    const Float8 all = density + halo;
    const Float8 left = lanes.transmittance * exponential(-extinction * all * (sample.length * mStep));
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
    queue.put(queue.texture + end, sample.texture, order);
    queue.put(queue.magnitude + end, sample.magnitude, order);
    queue.end = end + __builtin_popcount(seen);
}

VDBLIC_KERNEL
void RayKernel::trace(const RayTask* tasks, int count, RaySum* sums) const
{
    Lanes lanes{};
    for (Int8& origin : lanes.blockOrigin)
        origin = broadcastInt8(-1); // of no block
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
        lanes.taken += 1;
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
            queue.place[i] = queue.texture[i] = queue.magnitude[i] = 0;
            for (float* fraction : queue.fraction)
                fraction[i] = 0;
        }
        mShader.shade(queue, tasks, sums);
        queue.begin += kLanes;
    }
}

} // namespace vdblic
