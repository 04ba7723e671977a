#include "vdblic/cast/solid_extent.h"

#include "vdblic/cast/solid.h"
#include "vdblic/volume/voxel_box.h"

#include <glm/matrix.hpp>

namespace vdblic {

std::vector<glm::dvec3> solidExtent(const Solid& solid)
{
    constexpr float kSurface = 0.5f; // distance of a voxel's centre from its face
    std::vector<VoxelBox> boxes;
    openvdb::CoordBBox all;
    for (auto leaf = solid.levelSet->tree().cbeginLeaf(); leaf; ++leaf) {
        openvdb::CoordBBox box;
        for (auto value = leaf->cbeginValueOn(); value; ++value) {
            if (*value < kSurface) box.expand(value.getCoord());
        }
        if (box.empty()) continue;
        all.expand(box);
        const openvdb::Coord &low = box.min(), &high = box.max();
        boxes.push_back({{low[0], low[1], low[2]}, {high[0], high[1], high[2]}});
    }
    if (boxes.empty()) return {};
    const openvdb::Coord dim = all.dim();
    const glm::dmat4 indexToWorld = glm::inverse(solid.worldToIndex);
    std::vector<glm::dvec3> points;
    for (const VoxelBox& box : outermost(boxes, {dim[0], dim[1], dim[2]})) {
        const auto corners = box.corners(indexToWorld);
        points.insert(points.end(), corners.begin(), corners.end());
    }
    return points;
}

} // namespace vdblic
