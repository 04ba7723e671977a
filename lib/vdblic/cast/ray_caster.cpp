#include "vdblic/cast/ray_caster.h"

#include "vdblic/camera/camera.h"
#include "vdblic/cast/divided_rays.h"
#include "vdblic/cast/ray_cast_params.h"
#include "vdblic/cast/ray_kernel.h"
#include "vdblic/cast/ray_setup.h"
#include "vdblic/cast/sample_shader.h"
#include "vdblic/cast/surface_picture.h"
#include "vdblic/core/paging.h"
#include "vdblic/core/reporter.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/texture_volume.h"
#include "vdblic/volume/visible_space.h"

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <tbb/parallel_for.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <stop_token>
#include <vector>

namespace vdblic {
namespace {

constexpr float kNowhere = std::numeric_limits<float>::infinity();

/// The part of a ray's alpha that has a colour.
float shadedAlpha(const RaySum& sum)
{
    return sum.alpha - sum.halo - sum.waiting;
}

PixelLayers layersOf(const RaySum& sum, const RayTask& task)
{
    PixelLayers layers;
    layers.samples = float(sum.samples);
    if (!(sum.alpha > 0)) return layers;
    const float weight = shadedAlpha(sum);
    const float haloDepth = task.shading[kEntryDepth] * sum.halo + task.shading[kDepthPerStep] * sum.haloDistance;
    layers.depth = (sum.numbers[0] + haloDepth) / (weight + sum.halo);
    if (!(weight > 0)) return layers; // halos have only a depth
    layers.driver = sum.numbers[1] / weight;
    layers.texture = sum.numbers[2] / weight;
    const glm::vec3 normal(sum.normal[0], sum.normal[1], sum.normal[2]);
    if (const float length = glm::length(normal); length > 0) layers.normal = normal / length;
    return layers;
}

/// What a part of a ray shows. @param surface behind it  @param behind background
glm::vec4 pixelOf(const RaySum& sum, const glm::vec4& surface, const glm::vec3& behind)
{
    // Samples too faint to be shaded get the colour of the others.
    const float part = shadedAlpha(sum), whole = part > 0 ? (sum.alpha - sum.halo) / part : 0;
    const glm::vec3 color = glm::vec3(sum.color[0], sum.color[1], sum.color[2]) * whole;
    const glm::vec3 gaps = seenThrough(surface, behind) * sum.halo;
    return {color + behind * (sum.color[3] * whole) + gaps, sum.alpha};
}

} // namespace

Image castRays(const TextureVolume& volume, const Look& look, const Camera& camera, const RayCastParams& params,
               const VisibleSpace& visible, int ray, const Scenery& scenery, const std::uint8_t* only,
               const std::stop_token& stop)
{
    const glm::ivec2 size = camera.size();
    Image image{size, std::vector<glm::vec4>(std::size_t(size.x) * std::size_t(size.y), glm::vec4(0))};
    if (params.layers) image.layers.resize(image.pixels.size(), PixelLayers{.depth = scenery.tubes ? 0 : kNowhere});
    const std::optional<SurfacePicture> surfaces = castSurfaces(scenery, volume, look, camera, ray, only);
    const SurfacePicture* const behind = surfaces ? &*surfaces : nullptr;
    std::optional<DividedRays> divided;
    if (scenery.tubes) divided.emplace(scenery, volume, look, camera, params, ray, behind, only);
    const glm::vec3 origin(visible.origin()[0], visible.origin()[1], visible.origin()[2]);
    const SampleShader shader(volume, look, camera, params, origin, scenery.light);
    const RaySetup setup(volume, visible, camera, params, shader, ray, divided ? divided->begins() : nullptr,
                         divided  ? divided->ends()
                         : behind ? behind->depths.data()
                                  : nullptr,
                         divided ? divided->active() : only);
    const RayKernel kernel(volume, look, params, visible, shader);
    const std::vector<glm::vec3> background = look.backgroundRows(size.y);
    constexpr int kTile = RaySetup::kTile;
    const glm::ivec2 low = camera.area().low, tiles = (camera.area().high - low + kTile - 1) / kTile;
    tbb::parallel_for(0, tiles.x * tiles.y, [&](int tile) {
        if (stop.stop_requested()) return;
        paging::breathe(RaySetup::kRays * paging::kLeafBytes);
        const glm::ivec2 corner = low + glm::ivec2(tile % tiles.x, tile / tiles.x) * kTile;
        std::array<RayTask, RaySetup::kRays> tasks;
        /// Cast the rays, and pass on what each shows.
        const auto cast = [&](const auto& endOf, const auto& show) {
            const int count = setup.rays(corner.x, corner.y, tasks.data());
            std::array<RaySum, RaySetup::kRays> sums{};
            kernel.trace(tasks.data(), count, sums.data());
            for (std::size_t i = 0; i < std::size_t(count); ++i) {
                const auto pixel = std::size_t(tasks[i].pixel);
                const glm::vec4 color = pixelOf(sums[i], endOf(pixel), background[pixel / std::size_t(size.x)]);
                show(pixel, color, params.layers ? layersOf(sums[i], tasks[i]) : PixelLayers{});
            }
        };
        if (!divided) {
            const auto surface = [&](std::size_t pixel) { return behind ? behind->colors[pixel] : glm::vec4(0); };
            cast(surface, [&](std::size_t pixel, const glm::vec4& color, const PixelLayers& layers) {
                image.pixels[pixel] = color;
                if (params.layers) image.layers[pixel] = layers;
            });
            return;
        }
        DividedRays::Tile rays(*divided, corner, background);
        while (!rays.isOver()) {
            cast([&](std::size_t pixel) { return rays.end(pixel); },
                 [&](std::size_t pixel, const glm::vec4& color, const PixelLayers& layers) {
                     DividedRays::Tile::blend(image, pixel, color, layers);
                 });
            rays.next(image);
        }
    });
    if (stop.stop_requested()) throw Stopped{};
    if (surfaces) addBehind(*surfaces, only, image);
    return image;
}

} // namespace vdblic
