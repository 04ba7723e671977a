#include "vdblic/cast/surface_picture.h"

#include "vdblic/camera/camera.h"
#include "vdblic/cast/depth_cue.h"
#include "vdblic/cast/earth_map.h"
#include "vdblic/cast/ground.h"
#include "vdblic/cast/light_grid.h"
#include "vdblic/cast/pixel_rays.h"
#include "vdblic/cast/solid.h"
#include "vdblic/image/image.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/placed_box.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <openvdb/tools/RayIntersector.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

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
/// @param color linear light  @param light shadows inside the box, or null  @param ray index among each pixel's rays
SurfacePicture castSolid(const Solid& solid, const glm::vec3& color, const PlacedBox& box, const Look& look,
                         const Camera& camera, const LightGrid* light, int ray, const std::uint8_t* only)
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
    const DepthCue cue(box, look, camera);
    const glm::dvec3 towardsLight = keyLight(look, camera);
    const glm::vec3 shown = color * float(std::exp2(-look.exposure)); // undoes the exposure
    const std::vector<glm::vec3> background = look.backgroundRows(size.y);
    tbb::parallel_for(
        tbb::blocked_range<int>(camera.area().low.y, camera.area().high.y), [&](const tbb::blocked_range<int>& rows) {
            auto intersector = prototype; // NOLINT(performance-unnecessary-copy-initialization): it has a cache
            for (int y = rows.begin(); y < rows.end(); ++y) {
                for (int x = camera.area().low.x; x < camera.area().high.x; ++x) {
                    const auto i = std::size_t(y) * std::size_t(size.x) + std::size_t(x);
                    if (only && !only[i]) continue;
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
                    const glm::dvec3 place = origin + direction * depth;
                    double lit = diffuseLight(look.shading, normal, glm::normalize(direction));
                    if (light) { // of the cell in front of the solid
                        const glm::dvec3 at(box.worldToIndex() * glm::dvec4(place, 1));
                        const glm::dvec3 outward = glm::normalize(glm::dmat3(box.worldToIndex()) * normal);
                        lit *= double(light->at(at + outward * double(light->cell())));
                    }
                    lit += ambientLight(normal, towardsLight);
                    picture.depths[i] = float(depth);
                    const glm::vec3 own =
                        solid.earth ? solid.earth->colored(shown, place, camera.pixelSize(place)) : shown;
                    const glm::vec3 seen =
                        glm::mix(own * float(lit), background[std::size_t(y)], cue.share(float(depth)));
                    picture.colors[i] = glm::vec4(seen, 1);
                    picture.normals[i] = glm::vec3(normal);
                }
            }
        });
    return picture;
}

} // namespace

std::optional<SurfacePicture> castSurfaces(const Scenery& scenery, const PlacedBox& box, const Look& look,
                                           const Camera& camera, int ray, const std::uint8_t* only)
{
    if (!scenery.solid && !scenery.ground) return std::nullopt;
    SurfacePicture surfaces;
    if (scenery.solid) {
        surfaces = castSolid(*scenery.solid, scenery.solidColor, box, look, camera, scenery.light, ray, only);
    } else {
        const auto count = std::size_t(camera.size().x) * std::size_t(camera.size().y);
        surfaces.depths.assign(count, std::numeric_limits<float>::infinity());
        surfaces.colors.resize(count);
        surfaces.normals.resize(count);
    }
    if (scenery.ground) scenery.ground->addTo(surfaces, box, look, camera, ray, only);
    return surfaces;
}

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

} // namespace vdblic
