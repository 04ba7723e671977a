#include "vdblic/render/sequence_bounds.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/texture_name.h"
#include "vdblic/io/vdb_file.h"

#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <openvdb/openvdb.h>

namespace vdblic {

std::optional<GridHeader> textureHeader(const FrameFile& file, const std::string& texture)
{
    try {
        const VdbHeader header = readVdbHeader(file.path);
        const std::string name = textureName(header.metadata, texture);
        if (auto found = gridHeader(header, name)) return found;
        const auto grid = readVdb(file.path).find<openvdb::FloatGrid>(name);
        if (!grid) return std::nullopt;
        return GridHeader{grid->transformPtr(), grid->evalActiveVoxelBoundingBox()};
    } catch (const InputError&) {
        return std::nullopt;
    }
}

Corners cornersOf(const openvdb::CoordBBox& box, const openvdb::math::Transform& transform)
{
    Corners corners;
    for (unsigned i = 0; i < 8; ++i) {
        openvdb::Vec3d corner;
        for (int axis = 0; axis < 3; ++axis)
            corner[axis] = i >> axis & 1 ? box.max()[axis] + 0.5 : box.min()[axis] - 0.5;
        const openvdb::Vec3d world = transform.indexToWorld(corner);
        corners[i] = {world[0], world[1], world[2]};
    }
    return corners;
}

std::optional<SequenceBounds> sequenceBounds(const std::vector<FrameFile>& files, const std::string& texture)
{
    std::optional<SequenceBounds> bounds;
    openvdb::math::Transform::Ptr transform;
    openvdb::CoordBBox indices;
    bool shared = true; // one transform for all
    glm::dvec3 low, high;
    for (const FrameFile& file : files) {
        const std::optional<GridHeader> header = textureHeader(file, texture);
        if (!header || header->box.empty() || !header->transform->isLinear()) continue;
        const Corners corners = cornersOf(header->box, *header->transform);
        if (!bounds) {
            bounds = SequenceBounds{corners, file};
            transform = header->transform;
            low = high = corners[0];
        }
        shared = shared && *header->transform == *transform;
        indices.expand(header->box);
        for (const glm::dvec3& corner : corners) {
            low = glm::min(low, corner);
            high = glm::max(high, corner);
        }
    }
    if (!bounds) return bounds;
    if (shared) {
        bounds->box = cornersOf(indices, *transform);
    } else {
        for (unsigned i = 0; i < 8; ++i)
            bounds->box[i] = {i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z};
    }
    return bounds;
}

} // namespace vdblic
