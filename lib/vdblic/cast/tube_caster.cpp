#include "vdblic/cast/tube_caster.h"

#include "vdblic/camera/camera.h"
#include "vdblic/camera/clipping.h"
#include "vdblic/cast/depth_cue.h"
#include "vdblic/cast/lanes.h"
#include "vdblic/cast/light_grid.h"
#include "vdblic/cast/lighting.h"
#include "vdblic/cast/pixel_rays.h"
#include "vdblic/cast/ray_cast_params.h"
#include "vdblic/cast/round_cones.h"
#include "vdblic/cast/tube_tree.h"
#include "vdblic/core/reporter.h"
#include "vdblic/look/look.h"

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
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

/// The sums over the tubes on each ray of a packet.
struct TubeSums {
    Float8 left = broadcast8(1); ///< transmittance
    Vector8 color{};
    Float8 gaps{}; ///< weight of halos
    Float8 far{};  ///< weight of the background that is seen in tubes
    Float8 depth{}, driver{}, texture{};
    Vector8 normal{};
    Int8 count{};

    VDBLIC_INLINE void add(const SeenTubes& tubes, bool hasLayers)
    {
        const Float8 all = left * tubes.alpha, weight = all - all * tubes.gap;
        color = color + tubes.color * ((1 - tubes.far) * weight);
        far += tubes.far * weight;
        gaps += all - weight;
        left -= all;
        if (!hasLayers) return;
        count -= tubes.isSeen; // true is −1
        depth += tubes.depth * all;
        driver += tubes.driver * weight;
        texture += tubes.texture * weight;
        normal = normal + tubes.normal * weight;
    }
    [[nodiscard]] PixelLayers layers(int lane) const
    {
        PixelLayers layers;
        layers.samples = float(count[lane]);
        const float alpha = 1 - left[lane];
        if (!(alpha > 0)) return layers;
        const float shown = alpha - gaps[lane];
        layers.depth = depth[lane] / alpha;
        layers.driver = driver[lane] / shown;
        layers.texture = texture[lane] / shown;
        const glm::vec3 sum(normal.x[lane], normal.y[lane], normal.z[lane]);
        if (const float length = glm::length(sum); length > 0) layers.normal = sum / length;
        return layers;
    }
};

VDBLIC_KERNEL void trace(const TubeCaster& caster, TubeCaster::Packet& packet, bool hasLayers, TubeSums& sums)
{
    SeenTubes tubes[TubeCaster::kMostTubes];
    while (const int count = caster.next(packet, tubes)) {
        for (int i = 0; i < count; ++i)
            sums.add(tubes[i], hasLayers);
    }
}

} // namespace

TubeCaster::TubeCaster(const TubeTree& tree, const Look& look, const Camera& camera, const RayCastParams& params,
                       const PlacedBox& box, const LightGrid* light)
    : mTree(tree), mTubes(tree.tubes()), mLook(look), mLight(light),
      mLeastTransmittance(float(params.leastTransmittance)), mVoxel(box.voxelSize() * mTubes.unitsPerWorld()),
      mReach(glm::length(glm::dvec3(mTubes.worldToTubes() * glm::dvec4(mTubes.corners().front(), 1)))),
      mCuts(params.clip.allPlanes()), mLighting(look.shading), mCue(box, look, camera), mToTubes(mTubes.worldToTubes()),
      mToLight(box.worldToIndex() * glm::inverse(mTubes.worldToTubes()))
{
}

void TubeCaster::add(const PixelRays::Line& pixel, double end, int lane, Packet& packet) const
{
    const DepthSpan span(pixel, end, mCuts);
    if (!(span.enter < span.leave)) return;
    const glm::dvec3 origin(mToTubes * glm::dvec4(pixel.origin, 1));
    const glm::dvec3 along = glm::dmat3(mToTubes) * pixel.direction;
    const double unitsPerDepth = glm::length(along);
    const glm::dvec3 direction = along / unitsPerDepth;
    // From the point next to the middle of the box, so that single precision serves.
    const double begin = std::max(span.enter * unitsPerDepth, -glm::dot(origin, direction) - 2 * mReach);
    const double leave = std::min(span.leave * unitsPerDepth - begin, 8 * mReach);
    if (!(leave > 0)) return;
    const auto lanesOf = [](const glm::dvec3& v) { return Float4{float(v.x), float(v.y), float(v.z), 0}; };
    packet.lines.origin.setLane(lane, lanesOf(origin + direction * begin));
    packet.lines.direction.setLane(lane, lanesOf(direction));
    packet.lines.end[lane] = float(leave);
    packet.lines.least[lane] = mLeastTransmittance;
    packet.lines.isActive[lane] = -1;
    packet.direction.setLane(lane, lanesOf(glm::normalize(pixel.direction)));
    packet.begin[lane] = float(begin / unitsPerDepth);
    packet.depthPerUnit[lane] = float(1 / unitsPerDepth);
}

VDBLIC_KERNEL
int TubeCaster::next(Packet& packet, SeenTubes* tubes) const
{
    TubeTree::Hits hits[TubeTree::kMostHits];
    const int count = mTree.next(packet.lines, hits);
    for (int i = 0; i < count; ++i)
        tubes[i] = light(packet, hits[i]);
    return count;
}

VDBLIC_INLINE SeenTubes TubeCaster::light(const Packet& packet, const TubeTree::Hits& hits) const
{
    const bool hasColors = !mTubes.colors().empty();
    std::uint32_t first[kLanes];
    for (int lane = 0; lane < kLanes; ++lane)
        first[lane] = mTubes.cones()[std::size_t(hits.cone[lane])].first;
    const Float8 driver = Tubes::valuesAt(mTubes.drivers(), first, hits.share);
    const Float8 value = hasColors ? Tubes::valuesAt(mTubes.colors(), first, hits.share) : driver;
    const Float8 opacity = Tubes::valuesAt(mTubes.opacities(), first, hits.share);
    const Int8 entry = hasColors ? mLook.transfer.colorEntries(value) : mLook.transfer.entries(value);
    const Float8 normal[] = {hits.normal.x, hits.normal.y, hits.normal.z};
    Light light{broadcast8(1), Float8{}};
    if (mLook.shading.model != ShadingModel::kNone) {
        const Float8 view[] = {packet.direction.x, packet.direction.y, packet.direction.z};
        light = mLighting.surface(normal, view);
    }
    const Float8 halo = mTree.halo(dot(hits.normal, packet.lines.direction));
    const Float8 depth = packet.begin + packet.depthPerUnit * hits.distance;
    if (mLight) {
        const Float8 arriving = arrivingLight(packet, hits);
        light = {light.lit * arriving, light.white * arriving};
    }
    Float4 shown[kLanes];
    for (int lane = 0; lane < kLanes; ++lane)
        std::memcpy(&shown[lane], &mLook.transfer.table()[entry[lane]], sizeof shown[lane]);
    Float8 channels[4];
    transpose(shown, channels);
    return {.isSeen = hits.isThere,
            .alpha = hits.alpha,
            .gap = halo / (1 + halo),
            .color = {channels[0] * light.lit + light.white, channels[1] * light.lit + light.white,
                      channels[2] * light.lit + light.white},
            .far = mCue.share(depth),
            .depth = depth,
            .driver = value,
            .texture = opacity,
            .normal = hits.normal};
}

/// Factors on the light, of the cell in front of each surface.
VDBLIC_INLINE Float8 TubeCaster::arrivingLight(const Packet& packet, const TubeTree::Hits& hits) const
{
    constexpr float kOutward = 0.5f; // cells
    const float outward = kOutward * float(mLight->cell()) * float(mVoxel);
    const Vector8 at = packet.lines.origin + packet.lines.direction * hits.distance + hits.normal * outward;
    Float8 position[3];
    for (int axis = 0; axis < 3; ++axis) {
        position[axis] = float(mToLight[0][axis]) * at.x + float(mToLight[1][axis]) * at.y +
                         float(mToLight[2][axis]) * at.z + float(mToLight[3][axis]);
    }
    return mLight->at(position);
}

Image castTubes(const TubeTree& tree, const Look& look, const Camera& camera, const RayCastParams& params, int ray,
                const Scenery& scenery, const std::uint8_t* only, const std::stop_token& stop)
{
    const glm::ivec2 size = camera.size();
    Image image{size, std::vector<glm::vec4>(std::size_t(size.x) * std::size_t(size.y), glm::vec4(0))};
    if (params.layers) image.layers.resize(image.pixels.size());
    tbb::enumerable_thread_specific<SurfaceCaster> surfaces(SurfaceCaster(scenery, tree.tubes(), look, camera));
    const std::vector<glm::vec3> backgrounds = look.backgroundRows(size.y);
    const TubeCaster caster(tree, look, camera, params, tree.tubes(), scenery.light);
    const PixelRays rays(camera, ray);
    constexpr int kTile = 16;
    const PictureArea area = camera.area();
    const glm::ivec2 tiles = (area.high - area.low + kTile - 1) / kTile;
    tbb::parallel_for(0, tiles.x * tiles.y, [&](int tile) {
        if (stop.stop_requested()) return;
        const glm::ivec2 low = area.low + glm::ivec2(tile % tiles.x, tile / tiles.x) * kTile;
        TubeCaster::Packet packet;
        SurfaceCaster& surface = surfaces.local();
        std::size_t pixels[kLanes];
        Surface behind[kLanes];
        int count = 0;
        const auto cast = [&] {
            TubeSums sums;
            trace(caster, packet, params.layers, sums);
            for (int lane = 0; lane < count; ++lane) {
                const std::size_t pixel = pixels[lane];
                const glm::vec3 background = backgrounds[pixel / std::size_t(size.x)];
                const glm::vec3 color(sums.color.x[lane], sums.color.y[lane], sums.color.z[lane]);
                const glm::vec3 gaps = seenThrough(behind[lane].color, background) * sums.gaps[lane];
                image.pixels[pixel] = glm::vec4(color + background * sums.far[lane] + gaps, 1 - sums.left[lane]);
                if (params.layers) image.layers[pixel] = sums.layers(lane);
                addBehind(behind[lane], image.pixels[pixel], params.layers ? &image.layers[pixel] : nullptr);
            }
            packet = {};
            count = 0;
        };
        for (int i = 0; i < kTile * kTile; ++i) { // in blocks of 4 × 2 pixels
            const int block = i / kLanes, blocks = kTile / 4;
            const glm::ivec2 at = low + glm::ivec2(block % blocks * 4 + i % 4, block / blocks * 2 + i / 4 % 2);
            if (at.x >= area.high.x || at.y >= area.high.y) continue;
            const std::size_t pixel = std::size_t(at.y) * std::size_t(size.x) + std::size_t(at.x);
            if (only && !only[pixel]) continue;
            const PixelRays::Line line = rays.at(at.x, at.y);
            pixels[count] = pixel;
            behind[count] = surface.at(line, at.y);
            caster.add(line, double(behind[count].depth), count, packet);
            if (++count == kLanes) cast();
        }
        cast();
    });
    if (stop.stop_requested()) throw Stopped{};
    return image;
}

} // namespace vdblic
