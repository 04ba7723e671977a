#include "vdblic/volume/visible_extent.h"

#include "vdblic/camera/clipping.h"
#include "vdblic/core/exchange.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/texture_volume.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

namespace vdblic {
namespace {

constexpr double kLeastExtinction = 0.02;     // extinction per voxel that counts as visible
constexpr double kLeastExtinctionShare = 0.1; // or this share of the volume's largest
constexpr int kDirections = 128;              // in which the outermost points are kept

/// Directions spread evenly over the sphere: Fibonacci's lattice.
glm::dvec3 evenDirection(int i)
{
    const double z = 1 - (2 * i + 1.0) / kDirections, angle = 2 * std::numbers::pi * std::numbers::phi * i;
    return {std::sqrt(1 - z * z) * std::cos(angle), std::sqrt(1 - z * z) * std::sin(angle), z};
}

/// A leaf's corners within the volume's bounds, in world space.
Corners leafCorners(const TextureVolume& volume, const openvdb::Coord& origin)
{
    const glm::dvec3 first = glm::dvec3(origin[0], origin[1], origin[2]) - 0.5;
    const glm::dvec3 low = glm::max(first, volume.low()), high = glm::min(first + 8.0, volume.high());
    Corners corners;
    for (unsigned i = 0; i < 8; ++i) {
        const glm::dvec4 corner(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z, 1);
        corners[i] = glm::dvec3(volume.indexToWorld() * corner);
    }
    return corners;
}

bool cutAway(const Corners& corners, const std::vector<ClipPlane>& planes)
{
    return std::any_of(planes.begin(), planes.end(), [&](const ClipPlane& plane) {
        return std::all_of(corners.begin(), corners.end(),
                           [&](const glm::dvec3& corner) { return glm::dot(corner - plane.point, plane.normal) <= 0; });
    });
}

/// The points that are outermost in some direction.
std::vector<glm::dvec3> outermostOf(const std::vector<glm::dvec3>& points, const TextureVolume& volume)
{
    std::vector<glm::dvec3> outermost;
    if (points.empty()) return outermost;
    const Corners box = volume.corners();
    const glm::dvec3 scale =
        1.0 / glm::max(glm::abs(box[7] - box[0]), glm::dvec3(1e-30)); // flat volumes have sides too
    for (int i = 0; i < kDirections; ++i) {
        const glm::dvec3 along = evenDirection(i) * scale;
        // Of points that are equally far out always the same one is taken, whatever their order.
        const auto key = [&](const glm::dvec3& point) {
            return std::tuple(glm::dot(point, along), point.x, point.y, point.z);
        };
        outermost.push_back(*std::max_element(points.begin(), points.end(),
                                              [&](const auto& a, const auto& b) { return key(a) < key(b); }));
    }
    return outermost;
}

} // namespace

std::vector<glm::dvec3> visibleExtent(const TextureVolume& volume, const Look& look, const ClipParams& clip,
                                      Exchange& exchange)
{
    std::vector<double> extinctions(volume.leafCount());
    for (std::size_t leaf = 0; leaf < extinctions.size(); ++leaf) {
        const LeafRange& range = volume.leafRange(leaf);
        if (volume.shown(leaf).isOff() || !look.contributes(range)) continue;
        extinctions[leaf] = look.transfer.mostExtinction(range.lowDriver, range.highDriver);
    }
    double most = extinctions.empty() ? 0 : *std::max_element(extinctions.begin(), extinctions.end());
    exchange.max({&most, 1});
    const double least = std::min(kLeastExtinction, kLeastExtinctionShare * most);
    const std::vector<ClipPlane> planes = clip.allPlanes();

    // Of each column of leaves along z only the ends can be outermost.
    std::map<std::pair<int, int>, std::pair<openvdb::Coord, openvdb::Coord>> columns;
    for (std::size_t leaf = 0; leaf < extinctions.size(); ++leaf) {
        const openvdb::Coord origin = volume.origin(leaf);
        if (!(extinctions[leaf] > 0 && extinctions[leaf] >= least) || cutAway(leafCorners(volume, origin), planes))
            continue;
        auto& [lowest, highest] = columns.try_emplace({origin[0], origin[1]}, origin, origin).first->second;
        lowest = std::min(lowest, origin);
        highest = std::max(highest, origin);
    }
    std::vector<glm::dvec3> points;
    for (const auto& [column, ends] : columns) {
        for (const openvdb::Coord& origin : {ends.first, ends.second}) {
            const Corners corners = leafCorners(volume, origin);
            points.insert(points.end(), corners.begin(), corners.end());
        }
    }
    points = outermostOf(points, volume);
    return exchange.isAlone() ? points : outermostOf(exchange.join(points), volume);
}

} // namespace vdblic
