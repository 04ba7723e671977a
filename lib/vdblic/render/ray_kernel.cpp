#include "vdblic/render/ray_kernel.h"

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
/// which was looked up.
struct RayKernel::Lanes {
    Float4 entry[kLanes], direction[kLanes], inverse[kLanes];
    float shift[kLanes];
    int sample[kLanes], segmentEnd[kLanes], rayEnd[kLanes], pixel[kLanes];
    const Domain::Mask* mask[kLanes];
    Float8 viewX, viewY, viewZ;
    Float8 transmittance, red, green, blue;
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

/// Go on to the next sample in a visible leaf, and find how many more are there. False at the ray's end.
VDBLIC_INLINE bool RayKernel::findSegment(Lanes& lanes, int lane) const
{
    const Float4 entry = lanes.entry[lane], direction = lanes.direction[lane];
    int n = lanes.sample[lane];
    while (n < lanes.rayEnd[lane]) {
        const Float4 position = entry + direction * ((float(n) + lanes.shift[lane]) * mStep);
        const Int4 voxel = voxelOf(position);
        const bool block = mVisible.block(voxel);
        const int leaf = block ? mVolume.domain().findLeaf(voxel) : -1;
        const bool visible = leaf >= 0 && mVisible.leaf(leaf);

        // The samples before the ray comes within the margin of leaving this box are surely inside.
        const int dim = block ? 8 : 1 << VisibleLeaves::kBlockShift;
        const Float4 low = __builtin_convertvector(voxel & -dim, Float4) - 0.5f;
        const Float4 exit = direction > 0 ? low + (float(dim) - mMargin) : low + mMargin;
        const Float4 distance = (exit - entry) * lanes.inverse[lane];
        const float nearest = std::min(std::min(distance[0], distance[1]), distance[2]);
        const float last = std::min(nearest / mStep - lanes.shift[lane], float(lanes.rayEnd[lane]));
        const int end = std::min(std::max(int(last), n) + 1, lanes.rayEnd[lane]);
        if (visible) {
            lanes.sample[lane] = n;
            lanes.segmentEnd[lane] = end;
            lanes.mask[lane] = &mVolume.domain().mask(std::size_t(leaf));
            return true;
        }
        n = end;
    }
    return false;
}

VDBLIC_INLINE bool RayKernel::start(Lanes& lanes, int lane, const RayTask& task) const
{
    lanes.entry[lane] = task.entry;
    lanes.direction[lane] = task.direction;
    const Float4 tiny = broadcast4(1e-12f);
    const Float4 size = task.direction < 0 ? -task.direction : task.direction;
    lanes.inverse[lane] = 1 / (size > tiny ? task.direction : tiny);
    lanes.shift[lane] = task.shift;
    lanes.sample[lane] = 0;
    lanes.rayEnd[lane] = task.samples;
    lanes.pixel[lane] = task.pixel;
    lanes.viewX[lane] = task.view[0];
    lanes.viewY[lane] = task.view[1];
    lanes.viewZ[lane] = task.view[2];
    lanes.transmittance[lane] = 1;
    lanes.red[lane] = lanes.green[lane] = lanes.blue[lane] = 0;
    return findSegment(lanes, lane);
}

/// The interpolated record at a lane's sample; of no coverage if its voxel is not active.
VDBLIC_INLINE Float8 RayKernel::sample(const Lanes& lanes, int lane) const
{
    const float distance = (float(lanes.sample[lane]) + lanes.shift[lane]) * mStep;
    const Float4 position = lanes.entry[lane] + lanes.direction[lane] * distance;
    if (!lanes.mask[lane]->isOn(Domain::offset(voxelOf(position)))) return Float8{};
    return Bricks::interpolate(mVolume.bricks().locate(position));
}

/// Add a sample of each lane to its ray.
VDBLIC_INLINE void RayKernel::shade(Lanes& lanes, const Float8* samples) const
{
    Float8 numbers[8];
    transpose(samples, numbers);
    const Float8 coverage = numbers[TextureVolume::kCoverage];
    const Float8 mean = coverage > 0 ? 1 / coverage : Float8{};

    // Magnitude chooses colour and extinction.
    const Int8 entries = mLook.transfer.entries(numbers[TextureVolume::kMagnitude] * mean);
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
    const Float8 stretched = mLook.texture.stretched(numbers[TextureVolume::kTexture] * mean);
    const Float8 depth = extinction * mLook.texture.density(stretched) * mStep;
    const Float8 opacity = coverage > 0 ? 1 - exponential(-depth) : Float8{};

    // Its gradient is the normal, the light comes from the eye.
    const Shading& shading = mLook.shading;
    const Float8 x = numbers[TextureVolume::kGradientX], y = numbers[TextureVolume::kGradientY],
                 z = numbers[TextureVolume::kGradientZ];
    const Float8 length = squareRoot(x * x + y * y + z * z);
    const Float8 along = x * lanes.viewX + y * lanes.viewY + z * lanes.viewZ;
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
}

VDBLIC_KERNEL
void RayKernel::trace(const RayTask* tasks, int count, glm::vec4* pixels) const
{
    Lanes lanes;
    Float8 samples[kLanes] = {};
    bool alive[kLanes] = {};
    int next = 0, active = 0;
    const auto refill = [&](int lane) {
        while (next < count && !alive[lane])
            alive[lane] = start(lanes, lane, tasks[next++]);
        active += alive[lane];
        samples[lane] = Float8{};
    };
    for (int lane = 0; lane < kLanes; ++lane)
        refill(lane);

    while (active > 0) {
        for (int lane = 0; lane < kLanes; ++lane) {
            if (alive[lane]) samples[lane] = sample(lanes, lane);
        }
        shade(lanes, samples);
        for (int lane = 0; lane < kLanes; ++lane) {
            if (!alive[lane]) continue;
            const bool open = lanes.transmittance[lane] >= mLeastTransmittance;
            if (open && ++lanes.sample[lane] < lanes.segmentEnd[lane]) continue;
            if (open && findSegment(lanes, lane)) continue;
            pixels[lanes.pixel[lane]] = {lanes.red[lane], lanes.green[lane], lanes.blue[lane],
                                         1 - lanes.transmittance[lane]};
            alive[lane] = false;
            --active;
            refill(lane);
        }
    }
}

} // namespace vdblic
