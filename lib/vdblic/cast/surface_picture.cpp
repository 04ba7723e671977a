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
#include <tbb/enumerable_thread_specific.h>
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

} // namespace

SurfaceCaster::SurfaceCaster(const Scenery& scenery, const PlacedBox& box, const Look& look, const Camera& camera)
    : mScenery(scenery), mBox(box), mCamera(camera), mLook(look), mCue(box, look, camera),
      mBackground(look.backgroundRows(camera.size().y)), mTowardsLight(keyLight(look, camera)),
      mSolidColor(scenery.solidColor * float(std::exp2(-look.exposure))), mExposure(float(std::exp2(look.exposure)))
{
    if (!scenery.solid || scenery.solid->levelSet->empty()) return;
    mSolid.emplace(*scenery.solid->levelSet);
    const openvdb::CoordBBox around = scenery.solid->levelSet->evalActiveVoxelBoundingBox();
    const openvdb::Vec3d middle = around.getCenter(), corner = around.max().asVec3d() + 1 - middle;
    mMiddle = {middle[0], middle[1], middle[2]};
    mSquare = corner.lengthSqr();
}

Surface SurfaceCaster::at(const PixelRays::Line& ray, int row)
{
    std::optional<Surface> found = solidAt(ray, row);
    if (!found) found = groundAt(ray, row);
    return found.value_or(Surface{});
}

std::optional<Surface> SurfaceCaster::solidAt(const PixelRays::Line& ray, int row)
{
    if (!mSolid) return std::nullopt;
    const Solid& solid = *mScenery.solid;
    const glm::dmat3 linear(solid.worldToIndex);
    const glm::dvec3 eye(solid.worldToIndex * glm::dvec4(ray.origin, 1)), along = linear * ray.direction;
    const double square = glm::dot(along, along), nearest = glm::dot(mMiddle - eye, along);
    const glm::dvec3 away = mMiddle - eye;
    if ((glm::dot(away, away) - mSquare) * square > nearest * nearest) return std::nullopt;
    const double perDepth = std::sqrt(square);
    const glm::dvec3 unit = along / perDepth;
    const openvdb::math::Ray<double> line({eye.x, eye.y, eye.z}, {unit.x, unit.y, unit.z}, 0,
                                          std::numeric_limits<double>::max() * perDepth);
    openvdb::Vec3d hit, gradient;
    double distance = 0;
    if (!mSolid->intersectsWS(line, hit, gradient, distance)) return std::nullopt;
    const double depth = distance / perDepth;
    const glm::dvec3 normal =
        glm::normalize(glm::transpose(linear) * glm::dvec3(gradient[0], gradient[1], gradient[2]));
    const glm::dvec3 place = ray.origin + ray.direction * depth;
    double lit = diffuseLight(mLook.shading, normal, glm::normalize(ray.direction));
    if (mScenery.light) { // of the cell in front of the solid
        const glm::dvec3 at(mBox.worldToIndex() * glm::dvec4(place, 1));
        const glm::dvec3 outward = glm::normalize(glm::dmat3(mBox.worldToIndex()) * normal);
        lit *= double(mScenery.light->at(at + outward * double(mScenery.light->cell())));
    }
    lit += ambientLight(normal, mTowardsLight);
    const glm::vec3 own =
        solid.earth ? solid.earth->colored(mSolidColor, place, mCamera.pixelSize(place)) : mSolidColor;
    const glm::vec3 seen = glm::mix(own * float(lit), mBackground[std::size_t(row)], mCue.share(float(depth)));
    return Surface{float(depth), glm::vec4(seen, 1), glm::vec3(normal)};
}

std::optional<Surface> SurfaceCaster::groundAt(const PixelRays::Line& ray, int row) const
{
    if (!mScenery.ground) return std::nullopt;
    const std::optional<Ground::Point> point = mScenery.ground->at(ray.origin, ray.direction);
    if (!point) return std::nullopt;
    const glm::vec3& behind = mBackground[std::size_t(row)];
    const glm::vec3 color = Ground::color(behind * mExposure) / mExposure;
    const glm::vec3 seen = glm::mix(color * point->light, behind, mCue.share(float(point->depth)));
    return Surface{float(point->depth), glm::vec4(seen, 1) * point->alpha, mScenery.ground->normal()};
}

std::optional<SurfacePicture> castSurfaces(const Scenery& scenery, const PlacedBox& box, const Look& look,
                                           const Camera& camera, int ray, const std::uint8_t* only)
{
    if (!scenery.solid && !scenery.ground) return std::nullopt;
    tbb::enumerable_thread_specific<SurfaceCaster> casters(SurfaceCaster(scenery, box, look, camera));
    const glm::ivec2 size = camera.size();
    const auto count = std::size_t(size.x) * std::size_t(size.y);
    SurfacePicture picture{std::vector<float>(count, Surface{}.depth), std::vector<glm::vec4>(count),
                           std::vector<glm::vec3>(count)};
    const PixelRays rays(camera, ray);
    const PictureArea& area = camera.area();
    tbb::parallel_for(area.low.y, area.high.y, [&](int y) {
        SurfaceCaster& caster = casters.local();
        for (int x = area.low.x; x < area.high.x; ++x) {
            const auto i = std::size_t(y) * std::size_t(size.x) + std::size_t(x);
            if (only && !only[i]) continue;
            const Surface surface = caster.at(rays.at(x, y), y);
            picture.depths[i] = surface.depth;
            picture.colors[i] = surface.color;
            picture.normals[i] = surface.normal;
        }
    });
    return picture;
}

void addBehind(const Surface& surface, glm::vec4& pixel, PixelLayers* layers)
{
    if (!std::isfinite(surface.depth)) return;
    const float alpha = pixel.a, rest = 1 - alpha, behind = rest * surface.color.a;
    pixel += surface.color * rest;
    if (surface.color.a == 1) pixel.a = 1;
    if (!layers || !(pixel.a > 0)) return;
    layers->depth = ((alpha > 0 ? alpha * layers->depth : 0) + behind * surface.depth) / pixel.a;
    const glm::vec3 normal = alpha * layers->normal + behind * surface.normal;
    if (const float length = glm::length(normal); length > 0) layers->normal = normal / length;
}

void addBehind(const SurfacePicture& surfaces, const std::uint8_t* only, Image& image)
{
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, image.pixels.size()), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            if (only && !only[i]) continue;
            addBehind(surfaces.at(i), image.pixels[i], image.layers.empty() ? nullptr : &image.layers[i]);
        }
    });
}

} // namespace vdblic
