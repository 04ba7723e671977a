#include "vdblic/cast/ray_caster.h"

#include "vdblic/camera/camera.h"
#include "vdblic/cast/depth_cue.h"
#include "vdblic/cast/ground.h"
#include "vdblic/cast/light_grid.h"
#include "vdblic/cast/pixel_rays.h"
#include "vdblic/cast/ray_cast_params.h"
#include "vdblic/cast/ray_kernel.h"
#include "vdblic/cast/ray_setup.h"
#include "vdblic/cast/sample_shader.h"
#include "vdblic/cast/solid.h"
#include "vdblic/cast/surface_picture.h"
#include "vdblic/core/paging.h"
#include "vdblic/core/reporter.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/texture_volume.h"
#include "vdblic/volume/visible_space.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <openvdb/tools/RayIntersector.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <stop_token>
#include <vector>

namespace vdblic {
namespace {

/// Light from everywhere, more from the side of the key light: a solid is seen in shadow, too, and its faces differ.
double ambientLight(const glm::dvec3& normal, const glm::dvec3& towardsLight)
{
    constexpr double kAmbient = 0.5, kSided = 0.5;
    return kAmbient * (1 + kSided * (glm::dot(normal, glm::normalize(towardsLight)) - 1) / 2);
}

/// Lambert's reflection of the look's lights.
double diffuseLight(const Shading& shading, const glm::dvec3& normal, const glm::dvec3& view)
{
    constexpr double kDiffuse = 0.5;
    double diffuse = std::max(-glm::dot(normal, view), 0.0) * double(shading.headLight);
    for (const DirectionalLight& light : shading.lights)
        diffuse += std::max(glm::dot(normal, glm::normalize(light.direction)), 0.0) * light.intensity;
    return kDiffuse * diffuse;
}

/// Find the first surface of a solid along each pixel's ray, and light it by the look's lights.
/// @param color linear light  @param light shadows of the volume, or null  @param ray index among each pixel's rays
SurfacePicture castSolid(const Solid& solid, const glm::vec3& color, const TextureVolume& volume, const Look& look,
                         const Camera& camera, const LightGrid* light, int ray)
{
    using Vec3 = openvdb::Vec3d;
    const glm::ivec2 size = camera.size();
    const auto count = std::size_t(size.x) * std::size_t(size.y);
    SurfacePicture picture{std::vector<float>(count, std::numeric_limits<float>::infinity()),
                           std::vector<glm::vec4>(count), std::vector<glm::vec3>(count)};
    if (solid.levelSet->empty()) return picture;
    const openvdb::tools::LevelSetRayIntersector<openvdb::FloatGrid> prototype(*solid.levelSet);
    const PixelRays rays(camera, ray);
    const glm::dmat3 linear(solid.worldToIndex);
    const DepthCue cue(volume, look, camera);
    const glm::dvec3 towardsLight = keyLight(look, camera);
    const glm::vec3 shown = color * float(std::exp2(-look.exposure)); // as asked for, at any exposure
    const std::vector<glm::vec3> background = look.backgroundRows(size.y);
    tbb::parallel_for(
        tbb::blocked_range<int>(camera.area().low.y, camera.area().high.y), [&](const tbb::blocked_range<int>& rows) {
            auto intersector = prototype; // it has a cache of its own
            for (int y = rows.begin(); y < rows.end(); ++y) {
                for (int x = camera.area().low.x; x < camera.area().high.x; ++x) {
                    const auto [origin, direction] = rays.at(x, y);
                    const glm::dvec3 eye(solid.worldToIndex * glm::dvec4(origin, 1)), along = linear * direction;
                    const double perDepth = glm::length(along);
                    const glm::dvec3 unit = along / perDepth;
                    const openvdb::math::Ray<double> line({eye.x, eye.y, eye.z}, {unit.x, unit.y, unit.z}, 0,
                                                          std::numeric_limits<double>::max() * perDepth);
                    Vec3 hit, gradient;
                    double distance = 0;
                    if (!intersector.intersectsWS(line, hit, gradient, distance)) continue;
                    const double depth = distance / perDepth;
                    const glm::dvec3 normal =
                        glm::normalize(glm::transpose(linear) * glm::dvec3(gradient[0], gradient[1], gradient[2]));
                    const auto i = std::size_t(y) * std::size_t(size.x) + std::size_t(x);
                    double lit = diffuseLight(look.shading, normal, glm::normalize(direction));
                    if (light) { // of the cell in front of the solid
                        const glm::dvec3 at(volume.worldToIndex() * glm::dvec4(origin + direction * depth, 1));
                        const glm::dvec3 outward = glm::normalize(glm::dmat3(volume.worldToIndex()) * normal);
                        lit *= double(light->at(at + outward * double(light->cell())));
                    }
                    lit += ambientLight(normal, towardsLight);
                    picture.depths[i] = float(depth);
                    const glm::vec3 seen =
                        glm::mix(shown * float(lit), background[std::size_t(y)], cue.share(float(depth)));
                    picture.colors[i] = glm::vec4(seen, 1);
                    picture.normals[i] = glm::vec3(normal);
                }
            }
        });
    return picture;
}

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
    if (!(weight > 0)) return layers; // halos have nothing but a depth
    layers.driver = sum.numbers[1] / weight;
    layers.texture = sum.numbers[2] / weight;
    const glm::vec3 normal(sum.normal[0], sum.normal[1], sum.normal[2]);
    if (const float length = glm::length(normal); length > 0) layers.normal = normal / length;
    return layers;
}

/// Blend surfaces behind the cast pixels of an image.
void addBehind(const SurfacePicture& surfaces, const std::uint8_t* only, Image& image)
{
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        if (!std::isfinite(surfaces.depths[i]) || (only && !only[i])) continue;
        glm::vec4& pixel = image.pixels[i];
        const glm::vec4& color = surfaces.colors[i];
        const float alpha = pixel.a, rest = 1 - alpha, behind = rest * color.a;
        pixel += color * rest;
        if (color.a == 1) pixel.a = 1;
        if (image.layers.empty() || !(pixel.a > 0)) continue;
        PixelLayers& layers = image.layers[i];
        layers.depth = ((alpha > 0 ? alpha * layers.depth : 0) + behind * surfaces.depths[i]) / pixel.a;
        const glm::vec3 normal = alpha * layers.normal + behind * surfaces.normals[i];
        if (const float length = glm::length(normal); length > 0) layers.normal = normal / length;
    }
}

/// Solid and ground; nothing if there is neither.
std::optional<SurfacePicture> surfacesOf(const Scenery& scenery, const TextureVolume& volume, const Look& look,
                                         const Camera& camera, int ray)
{
    if (!scenery.solid && !scenery.ground) return std::nullopt;
    SurfacePicture surfaces;
    if (scenery.solid) {
        surfaces = castSolid(*scenery.solid, scenery.solidColor, volume, look, camera, scenery.light, ray);
    } else {
        const auto count = std::size_t(camera.size().x) * std::size_t(camera.size().y);
        surfaces.depths.assign(count, std::numeric_limits<float>::infinity());
        surfaces.colors.resize(count);
        surfaces.normals.resize(count);
    }
    if (scenery.ground) scenery.ground->addTo(surfaces, volume, look, camera, ray);
    return surfaces;
}

} // namespace

Image castRays(const TextureVolume& volume, const Look& look, const Camera& camera, const RayCastParams& params,
               const VisibleSpace& visible, int ray, const Scenery& scenery, const std::uint8_t* only,
               const std::stop_token& stop)
{
    const glm::ivec2 size = camera.size();
    Image image{size, std::vector<glm::vec4>(std::size_t(size.x) * std::size_t(size.y), glm::vec4(0))};
    if (params.layers) image.layers.resize(image.pixels.size());
    const std::optional<SurfacePicture> surfaces = surfacesOf(scenery, volume, look, camera, ray);
    const glm::vec3 origin(visible.origin()[0], visible.origin()[1], visible.origin()[2]);
    const SampleShader shader(volume, look, camera, params, origin, scenery.light);
    const RaySetup setup(volume, visible, camera, params, shader, ray, surfaces ? surfaces->depths.data() : nullptr,
                         only);
    const RayKernel kernel(volume, look, params, visible, shader);
    const std::vector<glm::vec3> background = look.backgroundRows(size.y);
    constexpr int kTile = RaySetup::kTile;
    const glm::ivec2 low = camera.area().low, tiles = (camera.area().high - low + kTile - 1) / kTile;
    tbb::parallel_for(0, tiles.x * tiles.y, [&](int tile) {
        if (stop.stop_requested()) return;
        paging::breathe(RaySetup::kRays * paging::kLeafBytes);
        std::array<RayTask, RaySetup::kRays> tasks;
        const int count = setup.rays(low.x + tile % tiles.x * kTile, low.y + tile / tiles.x * kTile, tasks.data());
        std::array<RaySum, RaySetup::kRays> sums{};
        kernel.trace(tasks.data(), count, sums.data());
        for (std::size_t i = 0; i < std::size_t(count); ++i) {
            const RaySum& sum = sums[i];
            // Samples too faint to be shaded get the colour of the others.
            const float part = shadedAlpha(sum), whole = part > 0 ? (sum.alpha - sum.halo) / part : 0;
            const glm::vec3 color = glm::vec3(sum.color[0], sum.color[1], sum.color[2]) * whole;
            const auto pixel = std::size_t(tasks[i].pixel);
            const glm::vec3& behind = background[pixel / std::size_t(size.x)];
            const glm::vec4 surface = surfaces ? surfaces->colors[pixel] : glm::vec4(0);
            const glm::vec3 gaps = (glm::vec3(surface) + behind * (1 - surface.a)) * sum.halo;
            image.pixels[pixel] = glm::vec4(color + behind * (sum.color[3] * whole) + gaps, sum.alpha);
            if (params.layers) image.layers[pixel] = layersOf(sum, tasks[i]);
        }
    });
    if (stop.stop_requested()) throw Stopped{};
    if (surfaces) addBehind(*surfaces, only, image);
    return image;
}

} // namespace vdblic
