#include "vdblic/render/ray_kernel.h"

#include <glm/geometric.hpp>

#include <cmath>

namespace vdblic {
namespace {

constexpr int kLanes = 8;

/// e^x for x ≤ 0, to a relative 2e-7 and exact at 0: 2^i · e^(f ln 2), |f| ≤ ½, with a Taylor polynomial of degree 6.
VDBLIC_INLINE Float8 exponential(Float8 x)
{
    const Float8 scaled = x * 1.44269504f;
    const Float8 power = scaled > -126 ? scaled : broadcast8(-126);
    const Int8 whole = floorToInt(power + 0.5f);
    const Float8 t = (power - __builtin_convertvector(whole, Float8)) * 0.693147181f;
    const Float8 series =
        1 + t * (1 + t * (1 / 2.0f + t * (1 / 6.0f + t * (1 / 24.0f + t * (1 / 120.0f + t * (1 / 720.0f))))));
    return series * __builtin_bit_cast(Float8, (whole + 127) << 23);
}

VDBLIC_INLINE Float8 squareRoot(Float8 x)
{
    Float8 root;
    for (int i = 0; i < kLanes; ++i)
        root[i] = std::sqrt(x[i]);
    return root;
}

VDBLIC_INLINE bool anyLane(Int8 mask)
{
    using Long4 = std::int64_t __attribute__((vector_size(32)));
    const auto pairs = __builtin_bit_cast(Long4, mask);
    return (pairs[0] | pairs[1] | pairs[2] | pairs[3]) != 0;
}

/// Eight records of eight numbers into eight vectors of one number each.
VDBLIC_INLINE void transpose(const Float8* rows, Float8* columns)
{
    Float8 pairs[8], quads[8];
    for (int i = 0; i < 8; i += 2) {
        pairs[i] = __builtin_shufflevector(rows[i], rows[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
        pairs[i + 1] = __builtin_shufflevector(rows[i], rows[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
    }
    for (int i = 0; i < 8; i += 4) {
        for (int j = 0; j < 2; ++j) {
            quads[i + 2 * j] = __builtin_shufflevector(pairs[i + j], pairs[i + j + 2], 0, 1, 8, 9, 4, 5, 12, 13);
            quads[i + 2 * j + 1] = __builtin_shufflevector(pairs[i + j], pairs[i + j + 2], 2, 3, 10, 11, 6, 7, 14, 15);
        }
    }
    for (int i = 0; i < 4; ++i) {
        columns[i] = __builtin_shufflevector(quads[i], quads[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
        columns[i + 4] = __builtin_shufflevector(quads[i], quads[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
    }
}

} // namespace

/// Eight rays under way. The samples up to segmentEnd are sure to lie in the same visible leaf, but for the first,
/// which was looked up. A lane without a ray stands still where there is nothing.
struct RayKernel::Lanes {
    Float8 entry[3], direction[3], view[3];
    Float8 shift;
    Int8 sample, segmentEnd;
    Int8 origin[3];                   // of the leaf
    const Record* brick[kLanes];      // the leaf's records
    const Domain::Mask* mask[kLanes]; // null if all its voxels are active
    Float8 transmittance, red, green, blue;
    const RayTask* task[kLanes];

    [[nodiscard]] VDBLIC_INLINE bool idle(int lane) const { return task[lane] == nullptr; }
};

/// What each lane's samples add up to, for the layers of its pixel.
struct RayKernel::LayerSums {
    PixelLayers* pixels;
    Float8 position{}, normal[3]{}, magnitude{}, texture{};
    Int8 samples{};

    VDBLIC_INLINE void start(int lane)
    {
        position[lane] = magnitude[lane] = texture[lane] = 0;
        normal[0][lane] = normal[1][lane] = normal[2][lane] = 0;
        samples[lane] = 0;
    }
    /// @param along of the gradient with the view: the normal is the gradient turned towards the eye
    VDBLIC_INLINE void add(const Lanes& lanes, Float8 weight, Float8 sampleMagnitude, Float8 sampleTexture,
                           const Float8* gradient, Float8 along, Float8 length)
    {
        position += weight * (__builtin_convertvector(lanes.sample, Float8) + lanes.shift);
        magnitude += weight * sampleMagnitude;
        texture += weight * sampleTexture;
        const Float8 towards = (along > 0 ? -weight : weight) / (length + 1e-20f);
        for (int axis = 0; axis < 3; ++axis)
            normal[axis] += towards * gradient[axis];
        samples += 1;
    }
    VDBLIC_INLINE void finish(const Lanes& lanes, int lane, float step) const
    {
        const RayTask& ray = *lanes.task[lane];
        PixelLayers& pixel = pixels[ray.pixel];
        pixel.samples = float(samples[lane]);
        const float alpha = 1 - lanes.transmittance[lane];
        if (!(alpha > 0)) return;
        pixel.depth = ray.entryDepth + position[lane] / alpha * step * ray.depthPerVoxel;
        pixel.magnitude = magnitude[lane] / alpha;
        pixel.texture = texture[lane] / alpha;
        const glm::vec3 sum(normal[0][lane], normal[1][lane], normal[2][lane]);
        if (const float length = glm::length(sum); length > 0) pixel.normal = sum / length;
    }
};

/// In place of LayerSums where no layer is asked for: costs nothing.
struct RayKernel::NoLayers {
    VDBLIC_INLINE void start(int) {}
    template<typename... Values>
    VDBLIC_INLINE void add(const Values&...)
    {
    }
    VDBLIC_INLINE void finish(const Lanes&, int, float) const {}
};

RayKernel::RayKernel(const TextureVolume& volume, const Look& look, const RayCastParams& params,
                     const VisibleLeaves& visible)
    : mVolume(volume), mLook(look), mVisible(visible), mStep(float(params.step)),
      mLeastTransmittance(float(params.leastTransmittance))
{
    // More than single precision can be wrong by, in voxels, when it says where a ray leaves a box.
    double reach = 0;
    for (int axis = 0; axis < 3; ++axis) {
        reach = std::max({reach, std::abs(volume.low()[axis]), std::abs(volume.high()[axis])});
    }
    mMargin = float(1e-5 + reach * 0x1p-20);
}

/// Go on to a lane's next sample in a visible leaf, and find how many more are there. False at the ray's end.
VDBLIC_INLINE bool RayKernel::findSegment(Lanes& lanes, int lane) const
{
    const RayTask& ray = *lanes.task[lane];
    const Float4 tiny = broadcast4(1e-12f); // in place of 0, so that no face is ever reached
    const Float4 size = ray.direction < 0 ? -ray.direction : ray.direction;
    const Float4 direction = size > tiny ? ray.direction : tiny;
    int n = lanes.sample[lane];
    while (n < ray.samples) {
        const Float4 position = ray.entry + ray.direction * ((float(n) + ray.shift) * mStep);
        const Int4 voxel = voxelOf(position);
        const bool block = mVisible.block(voxel);
        const int leaf = block ? mVolume.domain().findLeaf(voxel) : -1;
        const bool visible = leaf >= 0 && mVisible.leaf(leaf);

        // The samples before the ray comes within the margin of leaving this box are surely inside.
        const int dim = block ? 8 : 1 << VisibleLeaves::kBlockShift;
        const Int4 origin = voxel & -dim;
        const Float4 low = __builtin_convertvector(origin, Float4) - 0.5f;
        const Float4 exit = direction > 0 ? low + (float(dim) - mMargin) : low + mMargin;
        const Float4 distance = (exit - ray.entry) / direction;
        const float nearest = std::min(std::min(distance[0], distance[1]), distance[2]);
        const float last = std::min(nearest / mStep - ray.shift, float(ray.samples));
        const int end = std::min(std::max(int(last), n) + 1, ray.samples);
        if (visible) {
            lanes.sample[lane] = n;
            lanes.segmentEnd[lane] = end;
            for (int axis = 0; axis < 3; ++axis)
                lanes.origin[axis][lane] = origin[axis];
            lanes.brick[lane] = mVolume.bricks().locate(__builtin_convertvector(origin, Float4)).corner;
            const Domain::Mask& mask = mVolume.domain().mask(std::size_t(leaf));
            lanes.mask[lane] = mask.isOn() ? nullptr : &mask;
            return true;
        }
        n = end;
    }
    return false;
}

/// Give a lane the first ray that meets a visible leaf, or none.
VDBLIC_INLINE void RayKernel::refill(Lanes& lanes, int lane, const RayTask*& next, const RayTask* end) const
{
    while (next < end) {
        const RayTask& ray = *next++;
        lanes.task[lane] = &ray;
        lanes.sample[lane] = 0;
        if (!findSegment(lanes, lane)) continue;
        for (int axis = 0; axis < 3; ++axis) {
            lanes.entry[axis][lane] = ray.entry[axis];
            lanes.direction[axis][lane] = ray.direction[axis];
            lanes.view[axis][lane] = ray.view[axis];
        }
        lanes.shift[lane] = ray.shift;
        lanes.transmittance[lane] = 1;
        lanes.red[lane] = lanes.green[lane] = lanes.blue[lane] = 0;
        return;
    }
    static constexpr Record kNothing[Bricks::kDim * (Bricks::kDim + 1) + 2] = {};
    for (int axis = 0; axis < 3; ++axis) {
        lanes.entry[axis][lane] = lanes.direction[axis][lane] = lanes.view[axis][lane] = 0;
        lanes.origin[axis][lane] = 0;
    }
    lanes.brick[lane] = kNothing;
    lanes.mask[lane] = nullptr;
    lanes.task[lane] = nullptr;
    lanes.shift[lane] = 0;
    lanes.sample[lane] = 0;
    lanes.segmentEnd[lane] = std::numeric_limits<int>::max();
    lanes.transmittance[lane] = 1;
    lanes.red[lane] = lanes.green[lane] = lanes.blue[lane] = 0;
}

/// The interpolated records at the lanes' samples; of no coverage where the voxel is not active.
VDBLIC_INLINE void RayKernel::sample(const Lanes& lanes, Float8* samples) const
{
    const Float8 distance = (__builtin_convertvector(lanes.sample, Float8) + lanes.shift) * mStep;
    Float8 position[3], fraction[3];
    Int8 local[3], voxel[3];
    for (int axis = 0; axis < 3; ++axis) {
        position[axis] = lanes.entry[axis] + lanes.direction[axis] * distance;
        const Int8 base = floorToInt(position[axis]);
        local[axis] = base - lanes.origin[axis];
        fraction[axis] = position[axis] - __builtin_convertvector(base, Float8);
        voxel[axis] = floorToInt(position[axis] + 0.5f) & 7;
    }
    const Int8 records = (local[0] * Bricks::kDim + local[1]) * Bricks::kDim + local[2];
    const Int8 offsets = voxel[0] << 6 | voxel[1] << 3 | voxel[2];
    // Mostly a cell lies in the leaf's own brick; below its first voxels' centres it does not.
    const Int8 below = local[0] | local[1] | local[2];
    for (int lane = 0; lane < kLanes; ++lane) {
        if (lanes.mask[lane] && !lanes.mask[lane]->isOn(unsigned(offsets[lane]))) {
            samples[lane] = Float8{};
            continue;
        }
        Bricks::Cell cell{lanes.brick[lane] + records[lane], {fraction[0][lane], fraction[1][lane], fraction[2][lane]}};
        if (__builtin_expect(below[lane] < 0, 0)) {
            cell = mVolume.bricks().locate(Float4{position[0][lane], position[1][lane], position[2][lane]});
        }
        samples[lane] = Bricks::interpolate(cell);
    }
}

/// Add a sample of each lane to its ray.
template<typename Layers>
VDBLIC_INLINE void RayKernel::shade(Lanes& lanes, const Float8* samples, Layers& layers) const
{
    Float8 numbers[8];
    transpose(samples, numbers);
    const Float8 coverage = numbers[TextureVolume::kCoverage];
    const Float8 mean = coverage > 0 ? 1 / coverage : Float8{};

    // Magnitude chooses colour and extinction.
    const Float8 magnitude = numbers[TextureVolume::kMagnitude] * mean;
    const Int8 entries = mLook.transfer.entries(magnitude);
    Float4 rows[kLanes];
    for (int i = 0; i < kLanes; ++i)
        rows[i] = *reinterpret_cast<const Float4*>(mLook.transfer.table() + entries[i]);
    Float8 red, green, blue, extinction;
    for (int i = 0; i < kLanes; ++i) {
        red[i] = rows[i][0];
        green[i] = rows[i][1];
        blue[i] = rows[i][2];
        extinction[i] = rows[i][3];
    }

    // The texture modulates both.
    const Float8 texture = numbers[TextureVolume::kTexture] * mean;
    const Float8 stretched = mLook.texture.stretched(texture);
    const Float8 depth = extinction * mLook.texture.density(stretched) * mStep;
    const Float8 opacity = coverage > 0 ? 1 - exponential(-depth) : Float8{};

    // Its gradient is the normal, the light comes from the eye.
    const Shading& shading = mLook.shading;
    const Float8 x = numbers[TextureVolume::kGradientX], y = numbers[TextureVolume::kGradientY],
                 z = numbers[TextureVolume::kGradientZ];
    const Float8 length = squareRoot(x * x + y * y + z * z);
    const Float8 along = x * lanes.view[0] + y * lanes.view[1] + z * lanes.view[2];
    const Float8 facing = (along < 0 ? -along : along) / (length + 1e-20f);
    const Float8 highlight = facing / (shading.shininess + (1 - shading.shininess) * facing);
    const Float8 steepness = length * mean * (1 / (mLook.texture.high - mLook.texture.low));
    const Float8 surface = steepness / (steepness + shading.leastGradient);
    const Float8 lit = 1 + surface * (shading.ambient + shading.diffuse * facing - 1);
    const Float8 white = surface * highlight * shading.specular;

    const Float8 weight = lanes.transmittance * opacity;
    const Float8 tint = mLook.texture.brightness(stretched) * lit;
    lanes.red += weight * (red * tint + white);
    lanes.green += weight * (green * tint + white);
    lanes.blue += weight * (blue * tint + white);
    lanes.transmittance -= weight;
    layers.add(lanes, weight, magnitude, texture, numbers + TextureVolume::kGradientX, along, length);
}

template<typename Layers>
VDBLIC_INLINE void RayKernel::traceWith(const RayTask* tasks, int count, glm::vec4* pixels, Layers layers) const
{
    Lanes lanes;
    const RayTask *next = tasks, *end = tasks + count;
    int busy = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
        refill(lanes, lane, next, end);
        busy += !lanes.idle(lane);
    }
    Float8 samples[kLanes];
    while (busy > 0) {
        sample(lanes, samples);
        shade(lanes, samples, layers);
        lanes.sample += 1;
        const Int8 closed = lanes.transmittance < mLeastTransmittance;
        const Int8 attention = closed | (lanes.sample >= lanes.segmentEnd);
        if (!anyLane(attention)) continue;
        for (int lane = 0; lane < kLanes; ++lane) {
            if (!attention[lane] || lanes.idle(lane)) continue;
            if (!closed[lane] && findSegment(lanes, lane)) continue;
            pixels[lanes.task[lane]->pixel] = {lanes.red[lane], lanes.green[lane], lanes.blue[lane],
                                               1 - lanes.transmittance[lane]};
            layers.finish(lanes, lane, mStep);
            layers.start(lane);
            refill(lanes, lane, next, end);
            busy -= lanes.idle(lane);
        }
    }
}

VDBLIC_KERNEL
void RayKernel::trace(const RayTask* tasks, int count, glm::vec4* pixels) const
{
    traceWith(tasks, count, pixels, NoLayers{});
}

VDBLIC_KERNEL
void RayKernel::trace(const RayTask* tasks, int count, glm::vec4* pixels, PixelLayers* layers) const
{
    traceWith(tasks, count, pixels, LayerSums{layers});
}

} // namespace vdblic
