#include "vdblic/cast/ray_setup.h"

#include "vdblic/camera/clipping.h"
#include "vdblic/cast/blue_noise.h"
#include "vdblic/cast/pixel_rays.h"
#include "vdblic/cast/ray_cast_params.h"
#include "vdblic/cast/sample_shader.h"
#include "vdblic/volume/texture_volume.h"
#include "vdblic/volume/visible_space.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace vdblic {
namespace {

constexpr int kSquare = 4; // rays set up together: a square of pixels, row by row

/// The bits at even positions, packed: one coordinate of a position on Morton's curve (1966), which stays in small
/// squares.
int everySecondBit(int i)
{
    return (i & 1) | (i >> 1 & 2) | (i >> 2 & 4);
}

VDBLIC_INLINE Double4 evaluate(const PictureGradient<double>& gradient, Double4 x, Double4 y)
{
    return gradient.corner + gradient.perX * x + gradient.perY * y;
}

VDBLIC_INLINE void evaluate(const PictureGradient<glm::dvec3>& gradient, Double4 x, Double4 y, Double4* result)
{
    for (int axis = 0; axis < 3; ++axis)
        result[axis] = gradient.corner[axis] + gradient.perX[axis] * x + gradient.perY[axis] * y;
}

VDBLIC_INLINE Double4 length(const Double4* v)
{
    const Double4 square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    return Double4{std::sqrt(square[0]), std::sqrt(square[1]), std::sqrt(square[2]), std::sqrt(square[3])};
}

/// Numbers near 0 replaced by a tiny one: a ray then meets a face parallel to it at a huge distance.
VDBLIC_INLINE Double4 notZero(Double4 x)
{
    constexpr double kTiny = 1e-12;
    return ((x > kTiny) | (x < -kTiny)) ? x : Double4{} + kTiny;
}

/// Four columns of numbers into rows.
VDBLIC_INLINE void toRows(const Double4& a, const Double4& b, const Double4& c, const Double4& d, Float4* rows)
{
    const auto single = [](const Double4& x) { return __builtin_convertvector(x, Float4); };
    const Float4 ab = __builtin_shufflevector(single(a), single(b), 0, 4, 1, 5);
    const Float4 cd = __builtin_shufflevector(single(c), single(d), 0, 4, 1, 5);
    const Float4 abEnd = __builtin_shufflevector(single(a), single(b), 2, 6, 3, 7);
    const Float4 cdEnd = __builtin_shufflevector(single(c), single(d), 2, 6, 3, 7);
    rows[0] = __builtin_shufflevector(ab, cd, 0, 1, 4, 5);
    rows[1] = __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
    rows[2] = __builtin_shufflevector(abEnd, cdEnd, 0, 1, 4, 5);
    rows[3] = __builtin_shufflevector(abEnd, cdEnd, 2, 3, 6, 7);
}

/// The points of the lens that the rays of a square of pixels pass through.
void lensPoints(int left, int top, int ray, Double4& x, Double4& y)
{
    for (int lane = 0; lane < kSquare; ++lane) {
        const glm::dvec2 point = lensPoint(left + lane % 2, top + lane / 2, ray);
        x[lane] = point.x;
        y[lane] = point.y;
    }
}

/// Move rays from the middle of the lens to points of it.
VDBLIC_INLINE void throughLens(const Lens& lens, Double4 x, Double4 y, Double4* origin, Double4* direction)
{
    for (int axis = 0; axis < 3; ++axis) {
        const Double4 aside = lens.right[axis] * x + lens.up[axis] * y;
        origin[axis] += aside;
        direction[axis] -= aside * lens.perDepth;
    }
}

Float4 toFloat4(const glm::dvec3& v)
{
    return Float4{float(v.x), float(v.y), float(v.z), 0};
}

} // namespace

float sampleShift(int x, int y, int ray)
{
    // Ranks and the radical inverse, as fractions of 2³².
    std::uint32_t fraction = std::uint32_t(blueNoise().rank(x, y)) * (0x80000000u / (BlueNoise::kCount / 2));
    for (int bit = 31; ray != 0; ray >>= 1, --bit)
        fraction += std::uint32_t(ray & 1) << bit;
    return float(int(fraction >> 8)) * 0x1p-24f;
}

RaySetup::RaySetup(const TextureVolume& volume, const VisibleSpace& visible, const Camera& camera,
                   const RayCastParams& params, const SampleShader& shader, int ray, const float* begins,
                   const float* ends, const std::uint8_t* only)
    : mShader(shader), mSize(camera.size()), mStep(params.step), mRay(ray), mBegins(begins), mEnds(ends), mOnly(only),
      mWorld(camera.rays())
{
    const glm::dvec3 zero(visible.origin()[0], visible.origin()[1], visible.origin()[2]);
    mLow = volume.low() - zero;
    mHigh = volume.high() - zero;
    const glm::dmat3 toIndex(volume.worldToIndex());
    const auto linear = [&](const PictureGradient<glm::dvec3>& world) {
        return PictureGradient<glm::dvec3>{toIndex * world.corner, toIndex * world.perX, toIndex * world.perY};
    };
    mIndex = {linear(mWorld.origin), linear(mWorld.direction)};
    mIndex.origin.corner += glm::dvec3(volume.worldToIndex()[3]) - zero;
    if (const std::optional<Lens> lens = camera.lens())
        mLens = {*lens, {toIndex * lens->right, toIndex * lens->up, lens->perDepth}};

    const glm::dmat3 gradients = glm::transpose(toIndex); // of the index, by axis
    for (int axis = 0; axis < 3; ++axis) {
        const glm::dvec3 along = glm::normalize(gradients[axis]);
        mOutward.insert(mOutward.end(), {toFloat4(-along), toFloat4(along)});
    }
    for (const ClipPlane& plane : params.clip.allPlanes()) {
        const glm::dvec3 normal = glm::normalize(plane.normal);
        const auto along = [&](const PictureGradient<glm::dvec3>& world) {
            return PictureGradient<double>{glm::dot(world.corner, normal), glm::dot(world.perX, normal),
                                           glm::dot(world.perY, normal)};
        };
        Cut cut{along(mWorld.origin), along(mWorld.direction), 0, 0};
        if (mLens) {
            cut.lensRight = glm::dot(mLens->world.right, normal);
            cut.lensUp = glm::dot(mLens->world.up, normal);
        }
        cut.above.corner = glm::dot(mWorld.origin.corner - plane.point, normal);
        mCuts.push_back(cut);
        mOutward.push_back(toFloat4(-normal));
    }
}

VDBLIC_KERNEL
int RaySetup::rays(int x, int y, RayTask* tasks) const
{
    Float4 outward[kRays]; // of the faces where rays enter, see SampleShader::lightFaces()
    int count = 0;
    for (int i = 0; i < kRays / kSquare; ++i) {
        const int left = x + 2 * everySecondBit(i), top = y + 2 * everySecondBit(i >> 1);
        const Double4 pixelX = double(left) + Double4{0.5, 1.5, 0.5, 1.5};
        const Double4 pixelY = double(top) + Double4{0.5, 0.5, 1.5, 1.5};
        Double4 origin[3], direction[3], inverse[3];
        evaluate(mIndex.origin, pixelX, pixelY, origin);
        evaluate(mIndex.direction, pixelX, pixelY, direction);
        Double4 lensX{}, lensY{};
        if (mLens) {
            lensPoints(left, top, mRay, lensX, lensY);
            throughLens(mLens->index, lensX, lensY, origin, direction);
        }
        const Double4 voxelsPerDepth = length(direction), depthPerVoxel = 1 / voxelsPerDepth;

        Double4 enter{}, leave = enter + std::numeric_limits<double>::infinity(); // in voxels from the origin
        Long4 face = Long4{} - 1;                                                 // index in mOutward; −1: none
        for (int axis = 0; axis < 3; ++axis) {
            direction[axis] *= depthPerVoxel;
            inverse[axis] = 1 / notZero(direction[axis]);
            const Double4 low = (mLow[axis] - origin[axis]) * inverse[axis];
            const Double4 high = (mHigh[axis] - origin[axis]) * inverse[axis];
            const Double4 first = low < high ? low : high, last = low < high ? high : low;
            face = first > enter ? Long4(std::int64_t(2) * axis - (low > high)) : face;
            enter = first > enter ? first : enter;
            leave = last < leave ? last : leave;
        }
        for (std::size_t cut = 0; cut < mCuts.size(); ++cut) {
            Double4 growth = evaluate(mCuts[cut].slope, pixelX, pixelY);
            Double4 above = evaluate(mCuts[cut].above, pixelX, pixelY);
            if (mLens) {
                const Double4 aside = mCuts[cut].lensRight * lensX + mCuts[cut].lensUp * lensY;
                above += aside;
                growth -= aside * mLens->world.perDepth;
            }
            const Double4 slope = notZero(growth);
            const Double4 crossing = -above / slope * voxelsPerDepth;
            const Long4 in = slope > 0, later = in & (crossing > enter);
            face = later ? Long4{} + (6 + std::int64_t(cut)) : face;
            enter = later ? crossing : enter;
            leave = (~in & (crossing < leave)) ? crossing : leave;
        }
        if (mEnds) {
            for (int lane = 0; lane < kSquare; ++lane) {
                const int column = std::min(left + lane % 2, mSize.x - 1), row = std::min(top + lane / 2, mSize.y - 1);
                const double end = double(mEnds[std::size_t(row) * std::size_t(mSize.x) + std::size_t(column)]);
                leave[lane] = std::min(leave[lane], end * voxelsPerDepth[lane]);
                if (!mBegins) continue;
                const double begin = double(mBegins[std::size_t(row) * std::size_t(mSize.x) + std::size_t(column)]);
                const double start = begin * voxelsPerDepth[lane];
                if (start > enter[lane]) face[lane] = -1;
                enter[lane] = std::max(enter[lane], start);
            }
        }
        const Long4 hit = (enter < leave) & (pixelX < mSize.x) & (pixelY < mSize.y);

        Double4 view[3], entry[3];
        evaluate(mWorld.direction, pixelX, pixelY, view);
        if (mLens) {
            Double4 at[3]{};
            throughLens(mLens->world, lensX, lensY, at, view);
        }
        const Double4 perView = 1 / length(view), none{};
        for (int axis = 0; axis < 3; ++axis)
            entry[axis] = origin[axis] + direction[axis] * enter;
        const Double4 perStep = none + 1 / mStep, enterSteps = enter * perStep, span = (leave - enter) * perStep;
        Float4 entries[kSquare], directions[kSquare], inverses[kSquare], views[kSquare], depths[kSquare];
        toRows(entry[0], entry[1], entry[2], none, entries);
        toRows(direction[0], direction[1], direction[2], none, directions);
        toRows(inverse[0], inverse[1], inverse[2], none, inverses);
        toRows(view[0] * perView, view[1] * perView, view[2] * perView, none, views);
        toRows(none, enter * depthPerVoxel, mStep * depthPerVoxel, none, depths);
        for (int lane = 0; lane < kSquare; ++lane) {
            if (hit[lane] == 0) continue;
            const int pixel[] = {left + lane % 2, top + lane / 2}, index = pixel[1] * mSize.x + pixel[0];
            if (mOnly && !mOnly[index]) continue;
            const double start = double(sampleShift(pixel[0], pixel[1], mRay)) - enterSteps[lane];
            RayTask& task = tasks[count];
            task.entry = entries[lane];
            task.direction = directions[lane];
            task.inverse = inverses[lane];
            task.shading = __builtin_shufflevector(views[lane], depths[lane], 0, 1, 2, 3, 4, 5, 6, 7);
            task.shift = float(start - std::floor(start));
            task.span = float(span[lane]);
            task.samples = std::max(int(std::ceil(span[lane] - double(task.shift))), 0) + 1;
            task.pixel = index;
            outward[count] = face[lane] < 0 ? Float4{} : mOutward[std::size_t(face[lane])] + Float4{0, 0, 0, 1};
            ++count;
        }
    }
    mShader.lightFaces(outward, tasks, count);
    return count;
}

} // namespace vdblic
