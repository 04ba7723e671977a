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

/// A number for a cell, so that neighbours within a leaf differ as their records do; wraps around.
template<typename Integer>
VDBLIC_INLINE Integer placeNumber(Integer x, Integer y, Integer z)
{
    return (x * kBrickDim + y) * kBrickDim + z;
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

/// Eight rays under way. The samples up to segmentEnd are sure to lie in the same visible leaf, but for the first,
/// which was looked up. A lane without a ray stands still where there is nothing.
struct alignas(32) RayKernel::Lanes {
    Float8 entry[3], direction[3], inverse[3];
    Float8 view[3]; // direction in world space
    Float8 shift, span;
    Float8 transmittance, halo, haloPlace;
    Float8 waiting; // the weight of samples that added too little to be shaded
    Int8 samples, sample, segmentEnd, taken, task;
    Int8 leaf;
    Int8 offset;     // from a place's number in index space, placeNumber(), to that of its record
    unsigned masked; // lanes in leaves that are not shown whole
    unsigned busy;   // lanes that have a ray
};

/// What the lanes' samples met.
struct alignas(32) RayKernel::Sample {
    Float8 place, length; // along the ray [steps]
    Float8 fraction[3];   // in the cell
    Int8 record;          // number of the record at the cell's lowest corner
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

/// Find the leaves in which some lanes' next samples lie, and how many more do. @return the lanes whose leaf is
/// visible; the others have moved to the first sample behind it
VDBLIC_INLINE unsigned RayKernel::findSegments(Lanes& lanes, unsigned which) const
{
    const Float8 distance = samplePlace(lanes.sample, lanes.shift, lanes.span).place * mStep;
    Int8 voxel[3];
    for (int axis = 0; axis < 3; ++axis)
        voxel[axis] = __builtin_convertvector(lanes.entry[axis] + lanes.direction[axis] * distance + 0.5f, Int8);
    const Int8 found = mVisible.find(voxel, which);

    // The samples before the ray comes within the margin of leaving this box are surely inside.
    const Int8 dim =
        found == VisibleLeaves::kNoBlock ? broadcastInt8(1 << VisibleLeaves::kBlockShift) : broadcastInt8(8);
    const Float8 depth = __builtin_convertvector(dim, Float8) - mMargin;
    Int8 origin[3];
    Float8 nearest = broadcast8(std::numeric_limits<float>::infinity());
    for (int axis = 0; axis < 3; ++axis) {
        origin[axis] = voxel[axis] & -dim;
        const Float8 low = __builtin_convertvector(origin[axis], Float8) - 0.5f;
        const Float8 exit = low + (lanes.inverse[axis] > 0 ? depth : broadcast8(mMargin));
        const Float8 there = (exit - lanes.entry[axis]) * lanes.inverse[axis];
        nearest = there < nearest ? there : nearest;
    }
    const Float8 last = nearest * mPerStep - lanes.shift + 0.5f;
    const Float8 all = __builtin_convertvector(lanes.samples, Float8);
    const Int8 inside = __builtin_convertvector(last < all ? last : all, Int8);
    const Int8 next = (inside > lanes.sample ? inside : lanes.sample) + 1;
    const Int8 end = next < lanes.samples ? next : lanes.samples;

    const Int8 active = maskOf(which), visible = active & (found >= 0);
    lanes.sample = active & ~visible ? end : lanes.sample;
    lanes.segmentEnd = visible ? end : lanes.segmentEnd;
    lanes.leaf = visible ? found >> 1 : lanes.leaf;
    const auto number = Unsigned8(placeNumber(origin[0], origin[1], origin[2]));
    const auto first = Int8(Unsigned8(lanes.leaf) * kBrickSize + unsigned(brickIndex(0, 0, 0)) - number);
    lanes.offset = visible ? first : lanes.offset;
    const unsigned result = laneBits(visible);
    lanes.masked = (lanes.masked & ~result) | (laneBits((found & 1) != 0) & result);
    return result;
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
    setLane(lanes.task, lane, task);
    lanes.busy |= 1u << lane;
}

/// Let a lane stand still in the first leaf's first cell, where no light is left to take.
VDBLIC_INLINE void RayKernel::park(Lanes& lanes, int lane) const
{
    for (int axis = 0; axis < 3; ++axis) {
        setLane(lanes.entry[axis], lane, 0);
        setLane(lanes.direction[axis], lane, 0);
    }
    setLane(lanes.offset, lane, 0);
    setLane(lanes.transmittance, lane, 0);
    setLane(lanes.segmentEnd, lane, std::numeric_limits<int>::max());
    lanes.masked &= ~(1u << lane);
    lanes.busy &= ~(1u << lane);
}

/// Take lanes that left their leaf on to the next visible one, on their ray or, if that is over, on the next ray.
VDBLIC_INLINE void RayKernel::advance(const RayTask* tasks, int count, int& next, unsigned ended, Lanes& lanes,
                                      RaySum* sums) const
{
    while (ended != 0) {
        const Int8 over = (lanes.sample >= lanes.samples) | (lanes.transmittance < mLeastTransmittance);
        for (unsigned left = ended & laneBits(over); left != 0; left &= left - 1) {
            const int lane = __builtin_ctz(left);
            if (lanes.busy >> lane & 1) {
                RaySum& sum = sums[lanes.task[lane]];
                sum.alpha = 1 - lanes.transmittance[lane];
                sum.halo = lanes.halo[lane];
                sum.haloPlace = lanes.haloPlace[lane];
                sum.waiting = lanes.waiting[lane];
                sum.samples = lanes.taken[lane];
            }
            if (next < count) {
                load(tasks[next], next, lanes, lane);
                ++next;
            } else {
                park(lanes, lane);
                ended &= ~(1u << lane);
            }
        }
        ended &= ~findSegments(lanes, ended);
    }
}

/// Texture and magnitude at the lanes' samples.
VDBLIC_INLINE void RayKernel::sample(const Lanes& lanes, Sample& result) const
{
    const SamplePlaces sample = samplePlace(lanes.sample, lanes.shift, lanes.span);
    result.place = sample.place;
    result.length = sample.length;
    const Float8 distance = sample.place * mStep;
    Float8 position[3];
    Int8 base[3];
    for (int axis = 0; axis < 3; ++axis) {
        position[axis] = lanes.entry[axis] + lanes.direction[axis] * distance;
        base[axis] = __builtin_convertvector(position[axis], Int8); // none is negative
        result.fraction[axis] = position[axis] - __builtin_convertvector(base[axis], Float8);
    }
    result.record = placeNumber(base[0], base[1], base[2]) + lanes.offset;

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
    if (lanes.masked == 0) return;
    Int8 voxel[3];
    for (int axis = 0; axis < 3; ++axis)
        voxel[axis] = __builtin_convertvector(position[axis] + 0.5f, Int8) & 7;
    const Int8 offsets = voxel[0] << 6 | voxel[1] << 3 | voxel[2];
    for (unsigned left = lanes.masked; left != 0; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        result.hidden |= unsigned(!mVolume.shown(std::size_t(lanes.leaf[lane])).isOn(unsigned(offsets[lane]))) << lane;
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
    for (int axis = 0; axis < 3; ++axis)
        queue.put(queue.fraction[axis], sample.fraction[axis], order);
    queue.put(queue.record, sample.record, order);
    queue.put(queue.task, lanes.task, order);
    queue.put(queue.place, sample.place, order);
    queue.put(queue.weight, weight, order);
    queue.put(queue.texture, sample.texture, order);
    queue.put(queue.magnitude, sample.magnitude, order);
    queue.end += __builtin_popcount(seen);
}

VDBLIC_KERNEL
void RayKernel::trace(const RayTask* tasks, int count, RaySum* sums) const
{
    Lanes lanes{};
    ShadeQueue queue;
    int next = 0;
    advance(tasks, count, next, (1u << kLanes) - 1, lanes, sums);

    Sample met;
    while (lanes.busy != 0) {
        sample(lanes, met);
        // Which lanes leave their leaf does not depend on what they meet, so that the processor need not wait for it.
        lanes.sample += 1;
        lanes.taken += 1;
        const unsigned ended = laneBits(lanes.sample >= lanes.segmentEnd);
        absorb(lanes, met, queue);
        if (queue.end >= ShadeQueue::kMany) {
            for (; queue.begin + kLanes <= queue.end; queue.begin += kLanes)
                mShader.shade(queue, tasks, sums);
            queue.compact();
        }
        advance(tasks, count, next, ended, lanes, sums);
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
