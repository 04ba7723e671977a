#include "vdblic/cast/solid_caster.h"

#include "vdblic/camera/camera.h"
#include "vdblic/cast/depth_cue.h"
#include "vdblic/cast/light_grid.h"
#include "vdblic/cast/pixel_rays.h"
#include "vdblic/cast/solid.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/texture_volume.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <openvdb/tools/Interpolation.h>
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

/// The part of a ray that no cut takes away, in depths.
struct KeptPart {
    double enter = 0, leave = std::numeric_limits<double>::max();
    const ClipPlane* cut = nullptr; // through which the ray enters
};

KeptPart keptPart(std::span<const ClipPlane> cuts, const glm::dvec3& origin, const glm::dvec3& direction)
{
    KeptPart part;
    for (const ClipPlane& cut : cuts) {
        const double height = cut.height(origin), slope = glm::dot(direction, cut.normal);
        if (slope > 0 && -height / slope > part.enter) {
            part.enter = -height / slope;
            part.cut = &cut;
        }
        if (slope < 0) part.leave = std::min(part.leave, -height / slope);
        if (slope == 0 && height < 0) part.leave = -1;
    }
    return part;
}

/// @param at index space
bool isInside(const openvdb::FloatGrid::ConstAccessor& values, const glm::dvec3& at)
{
    return openvdb::tools::BoxSampler::sample(values, openvdb::Vec3d(at.x, at.y, at.z)) < 0;
}

} // namespace

SurfacePicture castSolid(const Solid& solid, const glm::vec3& color, std::span<const ClipPlane> cuts,
                         const TextureVolume& volume, const Look& look, const Camera& camera, const LightGrid* light,
                         int ray)
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
            const auto values = solid.levelSet->getConstAccessor();
            for (int y = rows.begin(); y < rows.end(); ++y) {
                for (int x = camera.area().low.x; x < camera.area().high.x; ++x) {
                    const auto [origin, direction] = rays.at(x, y);
                    const KeptPart part = keptPart(cuts, origin, direction);
                    if (!(part.enter < part.leave)) continue;
                    const glm::dvec3 eye(solid.worldToIndex * glm::dvec4(origin, 1)), along = linear * direction;
                    const double perDepth = glm::length(along);
                    const glm::dvec3 unit = along / perDepth;
                    double depth = part.enter;
                    glm::dvec3 normal;
                    if (const glm::dvec3 at = eye + along * depth; part.cut && isInside(values, at)) {
                        normal = -glm::normalize(part.cut->normal);
                    } else {
                        const openvdb::math::Ray<double> line({eye.x, eye.y, eye.z}, {unit.x, unit.y, unit.z},
                                                              part.enter * perDepth, part.leave * perDepth);
                        Vec3 hit, gradient;
                        double distance = 0;
                        if (!intersector.intersectsWS(line, hit, gradient, distance)) continue;
                        depth = distance / perDepth;
                        normal =
                            glm::normalize(glm::transpose(linear) * glm::dvec3(gradient[0], gradient[1], gradient[2]));
                    }
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

} // namespace vdblic
