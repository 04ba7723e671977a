#include "vdblic/cast/sample_shader.h"

#include "vdblic/camera/camera.h"
#include "vdblic/cast/lanes.h"
#include "vdblic/cast/light_grid.h"
#include "vdblic/cast/ray_cast_params.h"
#include "vdblic/cast/shade_queue.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/record_sampling.h"
#include "vdblic/volume/texture_volume.h"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cstring>

namespace vdblic {
namespace {

VDBLIC_INLINE Float8 load8(const float* values)
{
    Float8 result;
    std::memcpy(&result, values, sizeof result);
    return result;
}

/// Where the first eight samples of a queue are.
struct SamplePlaces {
    Float8 position[3];
    Unsigned8 leaf;

    VDBLIC_INLINE explicit SamplePlaces(const ShadeQueue& queue)
    {
        for (int axis = 0; axis < 3; ++axis)
            position[axis] = load8(queue.columns().position[axis] + queue.begin());
        std::memcpy(&leaf, queue.columns().leaf + queue.begin(), sizeof leaf);
    }
};

VDBLIC_INLINE const Float4& asFloat4(const TransferFunction::Entry& entry)
{
    return reinterpret_cast<const Float4&>(entry);
}

} // namespace

SampleShader::SampleShader(const TextureVolume& volume, const Look& look, const Camera& camera,
                           const RayCastParams& params, const glm::vec3& origin, const LightGrid* light)
    : mVolume(volume), mLook(look), mStep(float(params.step)), mLayers(params.layers), mIsCubic(params.isCubic()),
      mCue(volume, look, camera), mOrigin(origin), mLightGrid(light), mLighting(look.shading)
{
}

VDBLIC_INLINE Light SampleShader::lightLine(const ShadeQueue& queue, const Float8* view) const
{
    const SamplePlaces places(queue);
    const Cells cells(places.position);
    const Int8 corner = ScalarLeaf::index(cells.low[0], cells.low[1], cells.low[2]);
    const auto& [u, v, w] = cells.fraction;
    Float8 rows[kLanes], line[kLanes];
    for (int i = 0; i < kLanes; ++i) {
        const std::size_t leaf = std::size_t(places.leaf[i]) * ScalarLeaf::kSize;
        rows[i] = sampleLine(mVolume.lines() + leaf + corner[i], u[i], v[i], w[i]);
    }
    transpose(rows, line);
    // t (t·d) of the line's direction t and another one, d: independent of the sign of t.
    const auto along = [&](auto x, auto y, auto z, Float8* result) {
        result[0] = line[0] * x + line[3] * y + line[4] * z;
        result[1] = line[3] * x + line[1] * y + line[5] * z;
        result[2] = line[4] * x + line[5] * y + line[2] * z;
    };
    const auto squareSine = [](Float8 squareCosine) { return clamped(1 - squareCosine); };

    const Shading& shading = mLook.shading;
    Float8 viewed[3];
    along(view[0], view[1], view[2], viewed);
    const Float8 viewCosine = viewed[0] * view[0] + viewed[1] * view[1] + viewed[2] * view[2];
    const Float8 viewSine = squareSine(viewCosine);
    Float8 diffuse = viewSine * viewSine * shading.headLight;
    Float8 specular = mLighting.highlight(viewSine - viewCosine) * shading.headLight;
    for (const glm::vec4& light : mLighting.lights()) {
        Float8 lighted[3];
        along(light.x, light.y, light.z, lighted);
        const Float8 sine = squareSine(lighted[0] * light.x + lighted[1] * light.y + lighted[2] * light.z);
        const Float8 both = -(viewed[0] * light.x + viewed[1] * light.y + viewed[2] * light.z);
        diffuse += sine * sine * light.w;
        specular += mLighting.highlight(squareRoots(sine * viewSine) - both) * light.w;
    }
    return {shading.ambient + shading.diffuse * diffuse, shading.specular * specular};
}

VDBLIC_INLINE void SampleShader::addLayers(const ShadeQueue& queue, const Float8* normal, Float8 surface, Float8 depth,
                                           RaySum* sums) const
{
    const int first = queue.begin();
    const auto& samples = queue.columns();
    const Float8 weight = load8(samples.weight + first);
    const Float8 normals[] = {normal[0] * weight * surface, normal[1] * weight * surface, normal[2] * weight * surface,
                              Float8{}};
    const SamplePlaces places(queue);
    const ScalarRecords& scalar = mVolume.colors() ? *mVolume.colors() : mVolume.drivers();
    const Cells cells(places.position);
    const TextureSampler& sampler = mVolume.texture();
    const Float8 texture = mIsCubic ? sampler.cubicAt(places.leaf, cells) : sampler.at(places.leaf, cells);
    const Float8 numbers[] = {depth * weight, scalar.at(places.leaf, places.position) * weight, texture * weight,
                              Float8{}};
    Float4 rows[kLanes];
    transposeBack(normals, rows);
    for (int i = 0; i < kLanes; ++i)
        sums[samples.task[first + i]].normal += rows[i];
    transposeBack(numbers, rows);
    for (int i = 0; i < kLanes; ++i)
        sums[samples.task[first + i]].numbers += rows[i];
}

/// Factors on the light of the first eight samples of a queue.
VDBLIC_INLINE Float8 SampleShader::arrivingLight(const ShadeQueue& queue, const RayTask* tasks) const
{
    Float8 position[3];
    for (int i = 0; i < kLanes; ++i) {
        const RayTask& task = tasks[queue.columns().task[queue.begin() + i]];
        const float distance = queue.columns().distance[queue.begin() + i] * mStep;
        for (int axis = 0; axis < 3; ++axis)
            position[axis][i] = task.entry[axis] + task.direction[axis] * distance + mOrigin[axis];
    }
    return mLightGrid->at(position);
}

VDBLIC_KERNEL
void SampleShader::shade(const ShadeQueue& queue, const RayTask* tasks, RaySum* sums) const
{
    const int first = queue.begin();
    const auto& samples = queue.columns();
    Float8 rays[kLanes], ray[kLanes];
    for (int i = 0; i < kLanes; ++i)
        rays[i] = tasks[samples.task[first + i]].shading;
    transpose(rays, ray);
    const Float8* view = ray + kViewX;

    // The normal is the gradient over its length, turned towards the eye; a weak gradient is no surface.
    const bool surfaces = mLook.shading.model == ShadingModel::kSurface;
    Float8 normal[3] = {}, surface = {};
    if (surfaces || mLayers) {
        const SamplePlaces places(queue);
        Float8 inIndex[3], gradient[3];
        mVolume.texture().gradients(places.leaf, Cells(places.position), inIndex);
        const glm::mat3& toWorld = mVolume.gradientToWorld();
        for (int axis = 0; axis < 3; ++axis)
            gradient[axis] =
                toWorld[0][axis] * inIndex[0] + toWorld[1][axis] * inIndex[1] + toWorld[2][axis] * inIndex[2];
        const Float8 length =
            squareRoots(gradient[0] * gradient[0] + gradient[1] * gradient[1] + gradient[2] * gradient[2]);
        const Float8 along = gradient[0] * view[0] + gradient[1] * view[1] + gradient[2] * view[2];
        const Float8 unit = 1 / (length + 1e-20f);
        const Float8 scale = along > 0 ? -unit : unit;
        for (int axis = 0; axis < 3; ++axis)
            normal[axis] = gradient[axis] * scale;
        const Float8 steepness = length * (1 / (mLook.texture.high - mLook.texture.low));
        surface = steepness / (steepness + mLook.shading.leastGradient);
    }
    Light light{broadcast8(1), Float8{}};
    if (surfaces) {
        const Light full = mLighting.surface(normal, view);
        light = {1 + surface * (full.lit - 1), surface * full.white};
    } else if (mLook.shading.model == ShadingModel::kLine) {
        light = lightLine(queue, view);
    }
    // Samples within a voxel of the face are lit as the face.
    const Float8 distance = load8(samples.distance + first);
    const Float8 face = ray[kFaceLit] >= 0 ? clamped(1 - distance * mStep) : Float8{};
    light = {mix(light.lit, ray[kFaceLit], face), mix(light.white, ray[kFaceWhite], face)};

    if (mLightGrid) {
        const Float8 arriving = arrivingLight(queue, tasks);
        light = {light.lit * arriving, light.white * arriving};
    }

    // A scalar chooses the colour, the texture darkens it.
    Int8 entry;
    std::memcpy(&entry, samples.entry + first, sizeof entry);
    if (mVolume.colors()) {
        const SamplePlaces places(queue);
        entry = mLook.transfer.colorEntries(mVolume.colors()->at(places.leaf, places.position));
    }
    Float4 rows[kLanes];
    for (int i = 0; i < kLanes; ++i)
        rows[i] = asFloat4(mLook.transfer.table()[entry[i]]);
    Float8 color[4];
    transpose(rows, color);
    const Float8 tint = mLook.texture.brightness(load8(samples.stretched + first)) * light.lit;
    const Float8 depth = ray[kEntryDepth] + ray[kDepthPerStep] * distance;
    const Float8 far = mCue.share(depth);
    const Float8 weight = load8(samples.weight + first);
    for (int channel = 0; channel < 3; ++channel) {
        const Float8 seen = color[channel] * tint + light.white;
        color[channel] = seen * (1 - far) * weight;
    }
    color[3] = far * weight;
    transposeBack(color, rows);
    for (int i = 0; i < kLanes; ++i)
        sums[samples.task[first + i]].color += rows[i];
    if (mLayers) addLayers(queue, normal, surface, depth, sums);
}

VDBLIC_KERNEL
void SampleShader::lightFaces(const Float4* outward, RayTask* tasks, int count) const
{
    for (int first = 0; first < count; first += kLanes) {
        const int end = std::min(kLanes, count - first);
        Float4 normals[kLanes], views[kLanes];
        for (int i = 0; i < kLanes; ++i) {
            const int ray = first + std::min(i, end - 1);
            normals[i] = outward[ray];
            const Float8 shading = tasks[ray].shading;
            views[i] = __builtin_shufflevector(shading, shading, 0, 1, 2, 3);
        }
        Float8 normal[4], view[4];
        transpose(normals, normal);
        transpose(views, view);
        const Light light = mLighting.surface(normal, view);
        const bool lit = mLook.shading.model != ShadingModel::kNone;
        for (int i = 0; i < end; ++i) {
            tasks[first + i].shading[kFaceLit] = lit && normal[3][i] > 0 ? light.lit[i] : -1;
            tasks[first + i].shading[kFaceWhite] = light.white[i];
        }
    }
}

} // namespace vdblic
