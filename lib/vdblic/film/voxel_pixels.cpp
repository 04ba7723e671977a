#include "vdblic/film/voxel_pixels.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>

namespace vdblic {

double pixelsPerVoxel(const GridInfo& grid, const glm::dvec3& stretch, const glm::ivec2& size, ViewSide view,
                      bool isGlobe)
{
    const auto toWorld = [&](const openvdb::Vec3d& index) {
        const openvdb::Vec3d world = grid.transform->indexToWorld(index);
        return glm::dvec3(world[0], world[1], world[2]) * stretch;
    };
    const openvdb::Vec3d low = grid.box.min().asVec3d() - 0.5, high = grid.box.max().asVec3d() + 0.5;
    Corners corners;
    for (std::size_t i = 0; i < corners.size(); ++i)
        corners[i] = toWorld({(i & 1 ? high : low)[0], (i & 2 ? high : low)[1], (i & 4 ? high : low)[2]});
    std::vector<glm::dvec3> ball; // points around it
    for (const glm::dvec3& corner : corners) {
        if (isGlobe) ball.push_back(glm::mix(middleOf(corners), corner, 1 / std::sqrt(3.0)));
    }
    const Camera camera({.view = view}, corners, size, ball);
    const auto pixel = [&](const openvdb::Vec3d& index) {
        const glm::dvec4 at = camera.worldToNdc() * glm::dvec4(toWorld(index), 1);
        return glm::dvec2(at) / at.w * glm::dvec2(size);
    };
    const openvdb::Vec3d middle = (low + high) * 0.5;
    std::array<double, 3> spans{};
    for (int axis = 0; axis < 3; ++axis) {
        openvdb::Vec3d next = middle;
        next[axis] += 1;
        spans[std::size_t(axis)] = glm::length(pixel(next) - pixel(middle));
    }
    std::sort(spans.begin(), spans.end(), std::greater<>());
    return std::max((spans[0] + spans[1]) / 2, 1e-3);
}

} // namespace vdblic
