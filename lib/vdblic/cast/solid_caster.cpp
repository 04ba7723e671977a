#include "vdblic/cast/solid_caster.h"

#include "vdblic/camera/camera.h"
#include "vdblic/cast/depth_cue.h"
#include "vdblic/cast/light_grid.h"
#include "vdblic/cast/solid.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/texture_volume.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <openvdb/tools/RayIntersector.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <limits>

namespace vdblic {
namespace {

constexpr float kSolidAmbient = 0.35f, kSolidDiffuse = 0.65f;

/// Lambert's reflection of the look's lights.
float litShare(const Shading& shading, const glm::dvec3& normal, const glm::dvec3& view)
{
    double diffuse = std::max(-glm::dot(normal, view), 0.0) * double(shading.headLight);
    for (const DirectionalLight& light : shading.lights)
        diffuse += std::max(glm::dot(normal, glm::normalize(light.direction)), 0.0) * light.intensity;
    return kSolidAmbient + kSolidDiffuse * float(diffuse);
}

} // namespace

SolidPicture castSolid(const Solid& solid, const glm::vec3& color, const TextureVolume& volume, const Look& look,
                       const Camera& camera, const LightGrid* light)
{
    using Vec3 = openvdb::Vec3d;
    const glm::ivec2 size = camera.size();
    const auto count = std::size_t(size.x) * std::size_t(size.y);
    SolidPicture picture{std::vector<float>(count, std::numeric_limits<float>::infinity()),
                         std::vector<glm::vec3>(count), std::vector<glm::vec3>(count)};
    if (solid.levelSet->empty()) return picture;
    const openvdb::tools::LevelSetRayIntersector<openvdb::FloatGrid> prototype(*solid.levelSet);
    const PictureRays rays = camera.rays();
    const glm::dmat3 linear(solid.worldToIndex);
    const DepthCue cue(volume, look, camera);
    tbb::parallel_for(
        tbb::blocked_range<int>(camera.area().low.y, camera.area().high.y), [&](const tbb::blocked_range<int>& rows) {
            auto intersector = prototype; // it has a cache of its own
            for (int y = rows.begin(); y < rows.end(); ++y) {
                for (int x = camera.area().low.x; x < camera.area().high.x; ++x) {
                    const glm::dvec2 pixel(x + 0.5, y + 0.5);
                    const glm::dvec3 origin = rays.origin(pixel), direction = rays.direction(pixel);
                    const glm::dvec3 eye(solid.worldToIndex * glm::dvec4(origin, 1)), along = linear * direction;
                    const double perDepth = glm::length(along);
                    const glm::dvec3 unit = along / perDepth;
                    const openvdb::math::Ray<double> ray({eye.x, eye.y, eye.z}, {unit.x, unit.y, unit.z});
                    Vec3 hit, gradient;
                    double distance = 0;
                    if (!intersector.intersectsWS(ray, hit, gradient, distance)) continue;
                    const auto i = std::size_t(y) * std::size_t(size.x) + std::size_t(x);
                    const double depth = distance / perDepth;
                    const glm::dvec3 normal =
                        glm::normalize(glm::transpose(linear) * glm::dvec3(gradient[0], gradient[1], gradient[2]));
                    float lit = litShare(look.shading, normal, glm::normalize(direction));
                    if (light)
                        lit *= light->at(glm::dvec3(volume.worldToIndex() * glm::dvec4(origin + direction * depth, 1)));
                    picture.depths[i] = float(depth);
                    picture.colors[i] = glm::mix(color * lit, look.background, cue.share(float(depth)));
                    picture.normals[i] = glm::vec3(normal);
                }
            }
        });
    return picture;
}

} // namespace vdblic
