#include "vdblic/cast/tube_caster.h"

#include "vdblic/camera/camera.h"
#include "vdblic/camera/clipping.h"
#include "vdblic/cast/depth_cue.h"
#include "vdblic/cast/lanes.h"
#include "vdblic/cast/light_grid.h"
#include "vdblic/cast/lighting.h"
#include "vdblic/cast/pixel_rays.h"
#include "vdblic/cast/ray_cast_params.h"
#include "vdblic/cast/tube_tree.h"
#include "vdblic/core/reporter.h"
#include "vdblic/look/look.h"

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

namespace vdblic {
namespace {

/// The depths between which a ray is in the box and in front of all cuts; the first is not below 0.
struct DepthSpan {
    double enter = 0, leave;

    DepthSpan(const PixelRays::Line& ray, double end, const std::vector<ClipPlane>& cuts) : leave(end)
    {
        for (const ClipPlane& cut : cuts) {
            const double slope = glm::dot(ray.direction, cut.normal), crossing = -cut.height(ray.origin) / slope;
            if (slope > 0) enter = std::max(enter, crossing);
            if (slope < 0) leave = std::min(leave, crossing);
            if (slope == 0 && cut.height(ray.origin) < 0) leave = 0;
        }
    }
};

/// The sums over the tubes on a ray.
struct TubeSum {
    float left = 1; ///< transmittance
    glm::vec3 color{0};
    float far = 0; ///< weight of the background that is seen in tubes
    PixelLayers layers{.depth = 0};

    void add(const SeenTube& tube)
    {
        const float weight = left * tube.alpha;
        layers.samples += 1;
        color += tube.color * ((1 - tube.far) * weight);
        far += tube.far * weight;
        layers.depth += tube.depth * weight;
        layers.driver += tube.driver * weight;
        layers.texture += tube.texture * weight;
        layers.normal += tube.normal * weight;
        left -= weight;
    }
};

PixelLayers layersOf(const TubeSum& sum)
{
    PixelLayers layers;
    layers.samples = sum.layers.samples;
    const float alpha = 1 - sum.left;
    if (!(alpha > 0)) return layers;
    layers.depth = sum.layers.depth / alpha;
    layers.driver = sum.layers.driver / alpha;
    layers.texture = sum.layers.texture / alpha;
    if (const float length = glm::length(sum.layers.normal); length > 0) layers.normal = sum.layers.normal / length;
    return layers;
}

} // namespace

TubeCaster::TubeCaster(const TubeTree& tree, const Look& look, const Camera& camera, const RayCastParams& params,
                       const PlacedBox& box, const LightGrid* light)
    : mTree(tree), mTubes(tree.tubes()), mLook(look), mLight(light),
      mLeastTransmittance(float(params.leastTransmittance)), mVoxel(box.voxelSize() * mTubes.unitsPerWorld()),
      mCuts(params.clip.allPlanes()), mLighting(look.shading), mCue(box, look, camera), mToTubes(mTubes.worldToTubes()),
      mToLight(box.worldToIndex() * glm::inverse(mTubes.worldToTubes()))
{
}

/// The ray through a pixel; nullopt if it is cut away.
std::optional<TubeCaster::Ray> TubeCaster::rayOf(const PixelRays::Line& pixel, double end) const
{
    const DepthSpan span(pixel, end, mCuts);
    if (!(span.enter < span.leave)) return std::nullopt;
    const glm::dvec3 origin(mToTubes * glm::dvec4(pixel.origin, 1));
    const glm::dvec3 along = glm::dmat3(mToTubes) * pixel.direction;
    const double unitsPerDepth = glm::length(along);
    const glm::dvec3 direction = along / unitsPerDepth;
    // From the point next to the middle of the box, so that single precision serves.
    const double reach = glm::length(glm::dvec3(mToTubes * glm::dvec4(mTubes.corners().front(), 1)));
    const double begin = std::max(span.enter * unitsPerDepth, -glm::dot(origin, direction) - 2 * reach);
    const double leave = std::min(span.leave * unitsPerDepth - begin, 8 * reach);
    if (!(leave > 0)) return std::nullopt;
    const glm::dvec3 from = origin + direction * begin;
    return Ray{{{float(from.x), float(from.y), float(from.z)},
                {float(direction.x), float(direction.y), float(direction.z)},
                float(leave),
                mLeastTransmittance},
               glm::vec3(glm::normalize(pixel.direction)),
               begin / unitsPerDepth,
               1 / unitsPerDepth};
}

VDBLIC_KERNEL
void TubeCaster::light(const Ray& ray, const TubeTree::Hit* hits, int count, SeenTube* seen) const
{
    static_assert(TubeTree::kMostHits == kLanes);
    const bool hasColors = !mTubes.colors().empty();
    Float8 driver{}, value{}, opacity{}, distance{}, normal[3] = {};
    for (int i = 0; i < count; ++i) {
        const std::uint32_t first = mTubes.cones()[hits[i].cone].first;
        driver[i] = Tubes::valueAt(mTubes.drivers(), first, hits[i].share);
        if (hasColors) value[i] = Tubes::valueAt(mTubes.colors(), first, hits[i].share);
        opacity[i] = Tubes::valueAt(mTubes.opacities(), first, hits[i].share);
        distance[i] = hits[i].distance;
        for (int axis = 0; axis < 3; ++axis)
            normal[axis][i] = hits[i].normal[axis];
    }
    const Int8 entry = hasColors ? mLook.transfer.colorEntries(value) : mLook.transfer.entries(driver);
    Light light{broadcast8(1), Float8{}};
    if (mLook.shading.model != ShadingModel::kNone) {
        const Float8 view[] = {broadcast8(ray.direction.x), broadcast8(ray.direction.y), broadcast8(ray.direction.z)};
        light = mLighting.surface(normal, view);
    }
    const Float8 depth = float(ray.begin) + float(ray.depthPerUnit) * distance;
    const Float8 far = mCue.share(depth);
    if (mLight) {
        const Float8 arriving = arrivingLight(ray, distance, normal);
        light = {light.lit * arriving, light.white * arriving};
    }
    for (int i = 0; i < count; ++i) {
        const TransferFunction::Entry& shown = mLook.transfer.table()[entry[i]];
        seen[i] = {.alpha = hits[i].alpha,
                   .color = glm::vec3(shown.red, shown.green, shown.blue) * light.lit[i] + light.white[i],
                   .far = far[i],
                   .depth = depth[i],
                   .driver = hasColors ? value[i] : driver[i],
                   .texture = opacity[i],
                   .normal = glm::vec3(normal[0][i], normal[1][i], normal[2][i])};
    }
}

/// Factors on the light, of the cell in front of each surface.
VDBLIC_INLINE Float8 TubeCaster::arrivingLight(const Ray& ray, Float8 distance, const Float8* normal) const
{
    constexpr float kOutward = 0.5f; // cells
    const float outward = kOutward * float(mLight->cell()) * float(mVoxel);
    Float8 at[3], position[3];
    for (int axis = 0; axis < 3; ++axis)
        at[axis] = ray.line.origin[axis] + ray.line.direction[axis] * distance + outward * normal[axis];
    for (int axis = 0; axis < 3; ++axis) {
        position[axis] = float(mToLight[0][axis]) * at[0] + float(mToLight[1][axis]) * at[1] +
                         float(mToLight[2][axis]) * at[2] + float(mToLight[3][axis]);
    }
    return mLight->at(position);
}

Image castTubes(const TubeTree& tree, const Look& look, const Camera& camera, const RayCastParams& params, int ray,
                const Scenery& scenery, const std::uint8_t* only, const std::stop_token& stop)
{
    const glm::ivec2 size = camera.size();
    Image image{size, std::vector<glm::vec4>(std::size_t(size.x) * std::size_t(size.y), glm::vec4(0))};
    if (params.layers) image.layers.resize(image.pixels.size());
    const std::optional<SurfacePicture> surfaces = castSurfaces(scenery, tree.tubes(), look, camera, ray);
    const std::vector<glm::vec3> background = look.backgroundRows(size.y);
    const TubeCaster caster(tree, look, camera, params, tree.tubes(), scenery.light);
    const PixelRays rays(camera, ray);
    constexpr int kTile = 16;
    const PictureArea area = camera.area();
    const glm::ivec2 tiles = (area.high - area.low + kTile - 1) / kTile;
    tbb::parallel_for(0, tiles.x * tiles.y, [&](int tile) {
        if (stop.stop_requested()) return;
        const glm::ivec2 low = area.low + glm::ivec2(tile % tiles.x, tile / tiles.x) * kTile;
        for (int y = low.y; y < std::min(low.y + kTile, area.high.y); ++y) {
            for (int x = low.x; x < std::min(low.x + kTile, area.high.x); ++x) {
                const std::size_t pixel = std::size_t(y) * std::size_t(size.x) + std::size_t(x);
                if (only && !only[pixel]) continue;
                const double end = surfaces ? double(surfaces->depths[pixel]) : std::numeric_limits<double>::infinity();
                TubeSum sum;
                caster.trace(rays.at(x, y), end, [&](const SeenTube& tube) { sum.add(tube); });
                image.pixels[pixel] = glm::vec4(sum.color + background[std::size_t(y)] * sum.far, 1 - sum.left);
                if (params.layers) image.layers[pixel] = layersOf(sum);
            }
        }
    });
    if (stop.stop_requested()) throw Stopped{};
    if (surfaces) addBehind(*surfaces, only, image);
    return image;
}

} // namespace vdblic
