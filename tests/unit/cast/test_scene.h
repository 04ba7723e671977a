#pragma once

#include "vdblic/camera/camera.h"
#include "vdblic/cast/extinction_grid.h"
#include "vdblic/cast/light_grid.h"
#include "vdblic/cast/ray_cast_params.h"
#include "vdblic/cast/ray_caster.h"
#include "vdblic/cast/supersampling.h"
#include "vdblic/core/exchange.h"
#include "vdblic/image/image.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/texture_volume.h"
#include "vdblic/volume/visible_space.h"

#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <string>

namespace vdblic {

/// A float grid with the voxels of a box active, both corners included.
inline openvdb::FloatGrid::Ptr boxGrid(const std::string& name, const openvdb::CoordBBox& box,
                                       const std::function<float(const openvdb::Coord&)>& value)
{
    auto grid = openvdb::FloatGrid::create();
    grid->setName(name);
    auto accessor = grid->getAccessor();
    for (auto i = box.begin(); i; ++i)
        accessor.setValueOn(*i, value(*i));
    return grid;
}

inline openvdb::CoordBBox boxOf(int x, int y, int z)
{
    return {openvdb::Coord(0), openvdb::Coord(x - 1, y - 1, z - 1)};
}

/// A pseudo-random number from 0 to 1 for each voxel.
inline float scattered(const openvdb::Coord& c)
{
    unsigned h = unsigned(c.x()) * 73856093u ^ unsigned(c.y()) * 19349663u ^ unsigned(c.z()) * 83492791u;
    h = (h ^ (h >> 15)) * 2246822519u;
    return float((h ^ (h >> 13)) >> 8) * 0x1p-24f;
}

/// The light in a volume without a solid. @param visible look whose visible voxels take light
inline LightGrid lightIn(const TextureVolume& volume, const Look& visible, const glm::dvec3& towardsLight)
{
    OneProcess alone;
    const ExtinctionGrid extinctions(volume, visible, alone);
    return {extinctions, AmbientLight(extinctions, volume, visible), volume, visible, towardsLight};
}

/// White at one opacity, whatever texture, gradient and driver are.
inline Look plainLook(double opacity)
{
    const TransferFunction white({.colorMap = "gray", .opacity = {{0, opacity}}, .range = std::array{-2.0, -1.0}});
    return {white, {0, 1, 0, 0}, {.ambient = 1, .diffuse = 0, .specular = 0}};
}

/// A look with colours, opacities and shading that all matter.
inline Look fullLook()
{
    const TransferFunction transfer(
        {.opacity = {{0, 0}, {0.3, 0}, {0.6, 0.2}, {1, 0.7}}, .range = std::array{0.0, 1.0}});
    return {transfer, {0.2f, 0.9f, 0.8f}, {}};
}

/// The look chosen for a volume that is not empty; its thickness is the cube root of its number of voxels.
inline Look chooseLook(const LookParams& params, const TextureVolume& volume)
{
    return chooseLook(params, volume.samples(), std::cbrt(double(volume.domain().voxelCount())));
}

/// A camera that looks straight at the middle of a volume along a world direction.
inline Camera cameraAlong(const TextureVolume& volume, const glm::dvec3& direction, double distance, double fieldOfView,
                          const glm::ivec2& size)
{
    glm::dvec3 middle(0);
    for (const glm::dvec3& corner : volume.corners())
        middle += corner / 8.0;
    return Camera({.eye = middle - direction * distance, .target = middle, .fieldOfView = fieldOfView},
                  volume.corners(), size);
}

/// A picture of the leaves that the look makes visible.
inline Image castRays(const TextureVolume& volume, const Look& look, const Camera& camera, const RayCastParams& params)
{
    return castRays(volume, look, camera, params, VisibleSpace(volume, look));
}

/// How SampleSum casts a volume's rays. @param volume, look, visible must outlive the result
inline SampleSum::Cast castOf(const TextureVolume& volume, const Look& look, const VisibleSpace& visible,
                              const RayCastParams& params, const Scenery& scenery = {})
{
    return [&, params, scenery](const Camera& camera, int ray, const std::uint8_t* only, const std::stop_token& stop) {
        return castRays(volume, look, camera, params, visible, ray, scenery, only, stop);
    };
}

/// The same with several rays a pixel, as SampleSum adds them.
inline Image castSamples(const TextureVolume& volume, const Look& look, const Camera& camera,
                         const RayCastParams& params, int samples, const Scenery& scenery = {})
{
    const VisibleSpace visible(volume, look);
    SampleSum sum(castOf(volume, look, visible, params, scenery), camera);
    for (int sample = 0; sample < samples; ++sample)
        sum.add();
    return sum.mean();
}

/// The largest difference of any channel of any pixel.
inline float difference(const Image& a, const Image& b)
{
    float most = a.size == b.size ? 0 : 1;
    for (std::size_t i = 0; i < std::min(a.pixels.size(), b.pixels.size()); ++i) {
        const glm::vec4 d = glm::abs(a.pixels[i] - b.pixels[i]);
        most = std::max({most, d.r, d.g, d.b, d.a});
    }
    return most;
}

} // namespace vdblic
