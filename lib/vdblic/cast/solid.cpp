#include "vdblic/cast/solid.h"

#include "vdblic/camera/affine_transform.h"
#include "vdblic/cast/solid_mesh.h"
#include "vdblic/cast/terrain.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/extent.h"
#include "vdblic/core/memory.h"
#include "vdblic/image/vector_text.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/io/sequence.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/volume/inclusive_box.h"

#include <fmt/format.h>
#include <glm/ext/matrix_transform.hpp>
#include <glm/matrix.hpp>
#include <openvdb/tools/ChangeBackground.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/LevelSetFilter.h>
#include <openvdb/tools/LevelSetPlatonic.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/Morphology.h>
#include <openvdb/tools/TopologyToLevelSet.h>
#include <openvdb/tools/ValueTransformer.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

namespace vdblic {
namespace {

constexpr int kBand = 3;         // half the width of a level set's narrow band [voxels]
constexpr float kDeepest = 0.4f; // largest erosion of edges by smoothing [voxels]

using SolidTypes = openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid, openvdb::Int64Grid,
                                     openvdb::BoolGrid, openvdb::MaskGrid>;

glm::dmat4 toIndex(const openvdb::math::Transform& transform, const glm::dvec3& stretch, const std::string& where)
{
    return glm::inverse(glm::scale(glm::dmat4(1), stretch) * affineMatrix(transform, where));
}

openvdb::FloatGrid::Ptr unsmoothed(const openvdb::MaskTree::Ptr& voxels)
{
    return openvdb::tools::topologyToLevelSet(openvdb::MaskGrid(voxels), kBand, 0, 0, 0);
}

/// The voxels that no cube of 3 x 3 x 3 active ones holds: walls, lines and bodies of one or two voxels.
openvdb::MaskTree::Ptr thinParts(const openvdb::MaskTree& voxels)
{
    using namespace openvdb::tools;
    openvdb::MaskTree thick(voxels);
    erodeActiveValues(thick, 1, NN_FACE_EDGE_VERTEX, PRESERVE_TILES);
    dilateActiveValues(thick, 1, NN_FACE_EDGE_VERTEX, PRESERVE_TILES);
    auto thin = std::make_shared<openvdb::MaskTree>(voxels);
    thin->topologyDifference(thick);
    return thin;
}

/// Smooth stairs by a mean, which leaves faces where they are. It may not take away small bodies; thin parts that it
/// would take away stay as they are.
openvdb::FloatGrid::Ptr smoothed(const openvdb::MaskTree::Ptr& voxels)
{
    openvdb::FloatGrid::Ptr result = unsmoothed(voxels);
    const openvdb::FloatTree before(result->tree());
    openvdb::tools::LevelSetFilter<openvdb::FloatGrid> filter(*result);
    filter.setSpatialScheme(openvdb::math::FIRST_BIAS);
    filter.mean(1);
    const openvdb::MaskTree::Ptr kept = thinParts(*voxels);
    for (auto value = result->cbeginValueOn(); value; ++value)
        if (*value < 0 && kept->isValueOn(value.getCoord())) kept->setValueOff(value.getCoord());
    const openvdb::tree::ValueAccessor<const openvdb::FloatTree> distance(before);
    for (auto value = result->beginValueOn(); value; ++value)
        value.setValue(std::min(*value, distance.getValue(value.getCoord()) + kDeepest));
    filter.normalize();
    if (kept->activeVoxelCount() > 0) openvdb::tools::csgUnion(*result, *unsmoothed(kept));
    return result;
}

/// A level set whose faces are the faces of the voxels, half a voxel from their centres. Bodies that are cuboids along
/// the axes, such as buildings, have sharp edges; the others are smoothed.
openvdb::FloatGrid::Ptr levelSetOf(const openvdb::MaskTree::Ptr& voxels)
{
    checkVoxels(voxels->activeVoxelCount());
    const auto unit = openvdb::math::Transform::createLinearTransform();
    openvdb::FloatGrid::Ptr result = openvdb::createLevelSet<openvdb::FloatGrid>(1, kBand);
    std::vector<openvdb::MaskTree::Ptr> bodies;
    openvdb::tools::segmentActiveVoxels(*voxels, bodies);
    for (const openvdb::MaskTree::Ptr& body : bodies) {
        openvdb::CoordBBox box;
        body->evalActiveVoxelBoundingBox(box);
        if (box.empty() || body->activeVoxelCount() != std::uint64_t(voxelsOf(box))) continue;
        voxels->fill(box, false, false);
        const openvdb::BBoxd faces(box.min().asVec3d() - 0.5, box.max().asVec3d() + 0.5);
        openvdb::tools::csgUnion(*result, *openvdb::tools::createLevelSetBox<openvdb::FloatGrid>(faces, *unit, kBand));
    }
    if (voxels->activeVoxelCount() > 0) openvdb::tools::csgUnion(*result, *smoothed(voxels));
    return result;
}

/// The inactive voxels in the box around the active ones, as a solid.
openvdb::FloatGrid::Ptr complementOf(const openvdb::FloatGrid& texture)
{
    const openvdb::CoordBBox box = texture.evalActiveVoxelBoundingBox();
    const auto rest = std::make_shared<openvdb::MaskTree>();
    if (!box.empty()) {
        checkVoxels(std::uint64_t(voxelsOf(box)));
        rest->fill(box, true, true);
        rest->topologyDifference(openvdb::MaskTree(texture.tree(), false, true, openvdb::TopologyCopy()));
    }
    if (openvdb::FloatGrid::Ptr terrain = terrainOf(*rest, box, kBand)) return terrain;
    return levelSetOf(rest);
}

/// The voxels inside a mask, a fog volume or a level set.
template<typename GridT>
openvdb::MaskTree::Ptr insideOf(const GridT& grid)
{
    if constexpr (std::is_floating_point_v<typename GridT::ValueType>) {
        if (grid.getGridClass() == openvdb::GRID_LEVEL_SET) {
            const auto inside = openvdb::tools::sdfInteriorMask(grid);
            return std::make_shared<openvdb::MaskTree>(inside->tree(), false, true, openvdb::TopologyCopy());
        }
    }
    auto voxels = std::make_shared<openvdb::MaskTree>(grid.tree(), false, true, openvdb::TopologyCopy());
    if constexpr (!std::is_same_v<GridT, openvdb::MaskGrid>) {
        for (auto value = grid.cbeginValueOn(); value; ++value) {
            if (*value > 0) continue;
            openvdb::CoordBBox box;
            value.getBoundingBox(box);
            voxels->fill(box, false, false);
        }
    }
    return voxels;
}

/// A level set on cubic voxels stays as it is.
openvdb::FloatGrid::Ptr asLevelSet(const openvdb::GridBase& grid, const std::string& where)
{
    const auto* floats = dynamic_cast<const openvdb::FloatGrid*>(&grid);
    if (floats && floats->getGridClass() == openvdb::GRID_LEVEL_SET && floats->hasUniformVoxels()) {
        auto result = floats->deepCopy();
        const auto perVoxel = float(1 / result->voxelSize()[0]);
        openvdb::tools::foreach (result->beginValueAll(),
                                 [perVoxel](const auto& value) { value.setValue(*value * perVoxel); });
        openvdb::tools::changeBackground(result->tree(), result->background() * perVoxel);
        return result;
    }
    openvdb::FloatGrid::Ptr result;
    const bool known = grid.apply<SolidTypes>([&](const auto& typed) { result = levelSetOf(insideOf(typed)); });
    if (!known) {
        throw InputError(
            fmt::format("{}: a {} grid is no solid; use a level set, a fog volume or a mask", where, grid.valueType()));
    }
    return result;
}

/// Refuse a mesh that is far too large for the texture's voxels. @param mesh in index space
void checkExtent(const TriangleMesh& mesh, const std::filesystem::path& path)
{
    constexpr float kMostDistance = 1 << 24; // whole voxels are exact in single precision
    double voxels = 0;
    for (const openvdb::Vec3I& corners : mesh.triangles) {
        const openvdb::Vec3s a = mesh.points[corners[0]], b = mesh.points[corners[1]], c = mesh.points[corners[2]];
        voxels += double((b - a).cross(c - a).length()) * kBand;
    }
    const bool near = std::all_of(mesh.points.begin(), mesh.points.end(),
                                  [&](const openvdb::Vec3s& point) { return point.length() <= kMostDistance; });
    if (!near || !(voxels < 1e15)) {
        throw InputError(fmt::format("{}: is too large for the texture's voxels; bring it into the unit of the texture",
                                     path.string()));
    }
    checkVoxels(std::uint64_t(voxels), path.string());
}

Solid readSolid(const std::string& source, const openvdb::FloatGrid& texture, const glm::dvec3& stretch,
                std::int64_t frame)
{
    const auto [pattern, name] = parseGridReference(source);
    const std::filesystem::path path = FramePattern(pattern.string()).path(frame);
    if (isMeshFile(path)) {
        TriangleMesh mesh = readMesh(path);
        for (openvdb::Vec3s& point : mesh.points)
            point = openvdb::Vec3s(texture.transform().worldToIndex(openvdb::Vec3d(point)));
        checkExtent(mesh, path);
        const openvdb::math::Transform identity;
        return {openvdb::tools::meshToLevelSet<openvdb::FloatGrid>(identity, mesh.points, mesh.triangles, float(kBand)),
                toIndex(texture.transform(), stretch, "grid " + texture.getName())};
    }
    const VdbFile file = readVdb(path);
    const bool first = name.empty() && !file.grids.empty();
    const auto grid = first ? file.grids.front() : file.get<openvdb::GridBase>(name, "FILE:GRID");
    const std::string where = fmt::format("{}: grid {}", path.string(), grid->getName());
    const glm::dmat4 worldToIndex = toIndex(grid->transform(), stretch, where);
    return {asLevelSet(*grid, where), worldToIndex};
}

} // namespace

bool solidChanges(const std::string& source)
{
    return source == "domain" || FramePattern(parseGridReference(source).path.string()).hasField();
}

Solid makeSolid(const std::string& source, const openvdb::FloatGrid& texture, const glm::dvec3& stretch,
                std::int64_t frame)
{
    Solid solid;
    if (source == "domain") {
        solid = {complementOf(texture), toIndex(texture.transform(), stretch, "grid " + texture.getName())};
        const double box = voxelsOf(texture.evalActiveVoxelBoundingBox());
        if (box > 0) solid.share = 1 - double(texture.activeVoxelCount()) / box;
    } else {
        solid = readSolid(source, texture, stretch, frame);
    }
    solid.levelSet->setTransform(openvdb::math::Transform::createLinearTransform());
    solid.levelSet->setGridClass(openvdb::GRID_LEVEL_SET);
    return solid;
}

openvdb::CoordBBox boundsOf(const Solid& solid)
{
    openvdb::CoordBBox box;
    for (auto value = solid.levelSet->cbeginValueOn(); value; ++value) {
        if (*value < 0) box.expand(value.getCoord());
    }
    return box;
}

std::vector<glm::dvec3> solidExtent(const Solid& solid)
{
    constexpr float kSurface = 0.5f; // distance of a voxel's centre from its face
    std::vector<InclusiveBox> boxes;
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
    for (const InclusiveBox& box : outermost(boxes, {dim[0], dim[1], dim[2]})) {
        const auto corners = box.corners(indexToWorld);
        points.insert(points.end(), corners.begin(), corners.end());
    }
    return points;
}

} // namespace vdblic
