#include "vdblic/render/ray_kernel.h"

#include "vdblic/render/record_sampling.h"

namespace vdblic {
namespace {

struct SamplePlace {
    float place, length;
};
struct SamplePlaces {
    Float8 place, length;
};

/// Where a ray's sample lies and how much of the ray it stands for, in steps.
///
/// Samples are a step apart. What one stands for ends half-way to the next, the first's and the last's at the ends of
/// the span, and it lies in the middle of that: so a uniform medium is integrated exactly whatever the shift is.
VDBLIC_INLINE SamplePlaces samplePlace(Int8 sample, Float8 shift, Float8 span)
{
    const Float8 n = __builtin_convertvector(sample, Float8) + shift;
    const Float8 begin = sample > 0 ? n - 0.5f : Float8{}, after = n + 0.5f;
    const Float8 end = after < span ? after : span;
    return {(begin + end) * 0.5f, end - begin};
}
VDBLIC_INLINE SamplePlace samplePlace(int sample, float shift, float span)
{
    const float n = float(sample) + shift;
    const float begin = sample > 0 ? n - 0.5f : 0, after = n + 0.5f;
    const float end = after < span ? after : span;
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
    Float8 entry[3], direction[3];
    Float8 shift, span;
    Float8 transmittance, halo, haloPlace;
    Int8 sample, segmentEnd, taken, task;
    Int8 offset; // from a place's number in index space, placeNumber(), to that of its record
    const TextureVolume::Mask* mask[kLanes];
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

/// Go on to a lane's next sample in a visible leaf, and find how many more are there. False at the ray's end.
VDBLIC_INLINE bool RayKernel::findSegment(const RayTask* tasks, Lanes& lanes, int lane) const
{
    const RayTask& ray = tasks[lanes.task[lane]];
    int n = lanes.sample[lane];
    while (n < ray.samples) {
        const Float4 position = ray.entry + ray.direction * (samplePlace(n, ray.shift, ray.span).place * mStep);
        const Int4 voxel = __builtin_convertvector(position + 0.5f, Int4);
        const int found = mVisible.find(voxel);

        // The samples before the ray comes within the margin of leaving this box are surely inside.
        const int dim = found == VisibleLeaves::kNoBlock ? 1 << VisibleLeaves::kBlockShift : 8;
        const Int4 origin = voxel & -dim;
        const Float4 low = __builtin_convertvector(origin, Float4) - 0.5f;
        const Float4 exit = ray.inverse > 0 ? low + (float(dim) - mMargin) : low + mMargin;
        const Float4 distance = (exit - ray.entry) * ray.inverse;
        const float nearest = std::min(std::min(distance[0], distance[1]), distance[2]);
        const float last = std::min(nearest * mPerStep - ray.shift, float(ray.samples));
        const int end = std::min(std::max(int(last), n) + 1, ray.samples);
        if (found >= 0) {
            const int leaf = found >> 1;
            const unsigned first = unsigned(leaf) * kBrickSize + unsigned(brickIndex(0, 0, 0));
            setLane(lanes.sample, lane, n);
            setLane(lanes.segmentEnd, lane, end);
            setLane(lanes.offset, lane, int(first - unsigned(placeNumber(origin[0], origin[1], origin[2]))));
            lanes.mask[lane] = &mVolume.shown(std::size_t(leaf));
            lanes.masked = (lanes.masked & ~(1u << lane)) | unsigned(found & 1) << lane;
            return true;
        }
        n = end;
    }
    return false;
}

/// Give a lane the first ray that meets a visible leaf, or none.
VDBLIC_INLINE void RayKernel::refill(const RayTask* tasks, Lanes& lanes, int lane, int& next, int count) const
{
    setLane(lanes.halo, lane, 0);
    setLane(lanes.haloPlace, lane, 0);
    setLane(lanes.taken, lane, 0);
    while (next < count) {
        const RayTask& ray = tasks[next];
        setLane(lanes.task, lane, next++);
        setLane(lanes.sample, lane, 0);
        if (!findSegment(tasks, lanes, lane)) continue;
        for (int axis = 0; axis < 3; ++axis) {
            setLane(lanes.entry[axis], lane, ray.entry[axis]);
            setLane(lanes.direction[axis], lane, ray.direction[axis]);
        }
        setLane(lanes.shift, lane, ray.shift);
        setLane(lanes.span, lane, ray.span);
        setLane(lanes.transmittance, lane, 1);
        lanes.busy |= 1u << lane;
        return;
    }
    // Stand still in the first leaf's first cell, where no light is left to take.
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

    const ValueRecord* corners[kLanes];
    for (int lane = 0; lane < kLanes; ++lane)
        corners[lane] = mVolume.values() + unsigned(result.record[lane]);
    constexpr int kY = kBrickDim, kX = kBrickDim * kBrickDim;
    const auto both = [&](Float8 x, Float8 y, Float8 z, const ValueRecord* a, const ValueRecord* b) {
        const auto mix = [](Float8 from, Float8 to, Float8 t) { return from + (to - from) * t; };
        const auto pairs = [&](int i) { return loadPairs(a + i, b + i); };
        const Float8 across = mix(mix(pairs(0), pairs(kY), y), mix(pairs(kX), pairs(kX + kY), y), x);
        return mix(across, __builtin_shufflevector(across, across, 2, 3, 2, 3, 6, 7, 6, 7), z);
    };
    const auto& [x, y, z] = result.fraction;
    const Float8 values[] = {both(spread<0>(x), spread<0>(y), spread<0>(z), corners[0], corners[4]),
                             both(spread<1>(x), spread<1>(y), spread<1>(z), corners[1], corners[5]),
                             both(spread<2>(x), spread<2>(y), spread<2>(z), corners[2], corners[6]),
                             both(spread<3>(x), spread<3>(y), spread<3>(z), corners[3], corners[7])};
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
        result.hidden |= unsigned(!lanes.mask[lane]->isOn(unsigned(offsets[lane]))) << lane;
    }
}

/// The share of the extinction that halos add.
VDBLIC_INLINE Float8 RayKernel::haloShare(const RayTask* tasks, const Lanes& lanes, const Sample& sample,
                                          Float8 stretched) const
{
    Float8 density = mLook.halo.density(mLook.texture, stretched);
    for (int lane = 0; lane < kLanes; ++lane) {
        if (!(density[lane] > 0) || !(lanes.busy >> lane & 1)) continue;
        const Float4 gradient =
            sampleGradient(mVolume.gradients() + unsigned(sample.record[lane]), sample.fraction[0][lane],
                           sample.fraction[1][lane], sample.fraction[2][lane]);
        const Float8& view = tasks[lanes.task[lane]].shading;
        const float square = gradient[0] * gradient[0] + gradient[1] * gradient[1] + gradient[2] * gradient[2];
        const float along = gradient[0] * view[kViewX] + gradient[1] * view[kViewY] + gradient[2] * view[kViewZ];
        const float aside = square > 0 ? 1 - along * along / square : 0;
        density[lane] *= aside * aside;
    }
    return density;
}

/// Let the lanes' samples take their part of the light, and queue those that are seen.
VDBLIC_INLINE void RayKernel::absorb(const RayTask* tasks, Lanes& lanes, const Sample& sample, ShadeQueue& queue) const
{
    const Int8 entries = mLook.transfer.entries(sample.magnitude);
    Float8 extinction;
    for (int lane = 0; lane < kLanes; ++lane)
        extinction[lane] = mLook.transfer.extinctions()[entries[lane]];
    if (sample.hidden != 0) {
        for (int lane = 0; lane < kLanes; ++lane)
            extinction[lane] = sample.hidden >> lane & 1 ? 0 : extinction[lane];
    }
    const Float8 stretched = mLook.texture.stretched(sample.texture);
    const Float8 density = mLook.texture.density(stretched);
    const Float8 halo = mLook.halo.strength > 0 ? haloShare(tasks, lanes, sample, stretched) : Float8{};
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

    const unsigned seen = laneBits(weight > 0);
    if (seen == 0) return;
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
    for (int lane = 0; lane < kLanes; ++lane)
        refill(tasks, lanes, lane, next, count);

    Sample met;
    while (lanes.busy != 0) {
        sample(lanes, met);
        // Which lanes leave their leaf does not depend on what they meet, so that the processor need not wait for it.
        lanes.sample += 1;
        lanes.taken += 1;
        const unsigned ended = laneBits(lanes.sample >= lanes.segmentEnd);
        absorb(tasks, lanes, met, queue);
        if (queue.ready()) {
            mShader.shade(queue, tasks, sums);
            queue.pop();
        }
        for (unsigned left = ended; left != 0; left &= left - 1) {
            const int lane = __builtin_ctz(left);
            if (lanes.transmittance[lane] >= mLeastTransmittance && findSegment(tasks, lanes, lane)) continue;
            RaySum& sum = sums[lanes.task[lane]];
            sum.alpha = 1 - lanes.transmittance[lane];
            sum.halo = lanes.halo[lane];
            sum.haloPlace = lanes.haloPlace[lane];
            sum.samples = lanes.taken[lane];
            refill(tasks, lanes, lane, next, count);
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
