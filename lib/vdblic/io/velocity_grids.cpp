#include "vdblic/io/velocity_grids.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"

#include <openvdb/tree/LeafManager.h>

#include <array>
#include <cmath>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Mat3d;
using openvdb::Vec3d;
using openvdb::Vec3f;
using openvdb::Vec3SGrid;
using Components = std::array<FloatGrid::ConstPtr, 3>;

constexpr std::array<const char*, 3> kNames = {"velocity", "vel", "v"};
constexpr std::array<const char*, 3> kJoints = {".", "_", ""};

// Transforms are products of floats in many files.
constexpr double kTolerance = 1e-4;

/// A grid of double precision in single precision; its inactive values become 0.
template<typename Single, typename Double>
typename Single::Ptr narrowed(const Double& wide)
{
    using Value = typename Single::ValueType;
    auto tree =
        std::make_shared<typename Single::TreeType>(wide.tree(), openvdb::zeroVal<Value>(), openvdb::TopologyCopy());
    const auto source = wide.getConstAccessor();
    for (auto value = tree->beginValueOn(); value; ++value)
        value.setValue(Value(source.getValue(value.getCoord())));
    auto grid = Single::create(tree);
    grid->insertMeta(wide); // name and class are metadata too
    grid->setTransform(wide.transform().copy());
    return grid;
}

/// A vector grid of single or double precision as Vec3f.
Vec3SGrid::Ptr asVectors(const openvdb::GridBase::Ptr& grid)
{
    if (auto single = openvdb::gridPtrCast<Vec3SGrid>(grid)) return single;
    return narrowed<Vec3SGrid>(*openvdb::gridPtrCast<openvdb::Vec3DGrid>(grid));
}

FloatGrid::ConstPtr asScalars(const openvdb::GridBase::Ptr& grid)
{
    if (const auto single = openvdb::gridPtrCast<FloatGrid>(grid)) return single;
    return narrowed<FloatGrid>(*openvdb::gridPtrCast<openvdb::DoubleGrid>(grid));
}

bool isVector(const openvdb::GridBase::Ptr& grid)
{
    return grid->isType<Vec3SGrid>() || grid->isType<openvdb::Vec3DGrid>();
}

bool isScalar(const openvdb::GridBase::Ptr& grid)
{
    return grid->isType<FloatGrid>() || grid->isType<openvdb::DoubleGrid>();
}

openvdb::GridBase::Ptr gridOf(const VdbFile& file, const std::string& name,
                              bool (*isType)(const openvdb::GridBase::Ptr&))
{
    for (const auto& grid : file.grids) {
        if (grid->getName() == name && isType(grid)) return grid;
    }
    return nullptr;
}

/// The three scalar grids of a name, or nulls.
std::array<openvdb::GridBase::Ptr, 3> scalarsOf(const VdbFile& file, const std::string& name, std::string& fullName)
{
    for (const char* joint : kJoints) {
        std::array<openvdb::GridBase::Ptr, 3> grids;
        for (std::size_t axis = 0; axis < 3; ++axis)
            grids[axis] = gridOf(file, name + joint + "xyz"[axis], isScalar);
        if (grids[0] && grids[1] && grids[2]) {
            fullName = fmt::format("{0}{1}x, {0}{1}y, {0}{1}z", name, joint);
            return grids;
        }
    }
    return {};
}

void checkTransform(const openvdb::GridBase& grid, const std::string& where)
{
    if (!grid.transform().isLinear()) {
        throw InputError(where + " has a frustum transform; resample it onto a box-shaped grid");
    }
    const Mat3d axes = indexAxes(grid.transform());
    for (int a = 0; a < 3; ++a) {
        const Vec3d p = axes.col(a), q = axes.col((a + 1) % 3);
        if (!(p.length() > 0) || !std::isfinite(p.length())) {
            throw InputError(where + fmt::format(" has a voxel of size {} along axis {}", p.length(), a));
        }
        if (std::abs(p.dot(q)) > kTolerance * p.length() * q.length()) {
            throw InputError(where + " has a sheared transform; resample it onto a grid with right angles");
        }
    }
}

/// Where the three components stand.
struct Layout {
    openvdb::math::Transform::Ptr centres; ///< transform of the voxel centres
    bool staggered = false;
};

/// Components on one transform are staggered if their class says so. Houdini writes face-sampled components with a
/// transform each, shifted by half a voxel along its own axis.
Layout layoutOf(const Components& components, const std::string& where)
{
    const openvdb::math::Transform& first = components[0]->transform();
    const Mat3d toIndex = indexAxes(first).inverse();
    const auto originOf = [&](std::size_t axis) {
        return toIndex * (components[axis]->transform().indexToWorld(Vec3d(0)) - first.indexToWorld(Vec3d(0)));
    };
    const auto near = [](const Vec3d& a, const Vec3d& b) { return (a - b).length() < 1e-2; };
    for (std::size_t axis = 1; axis < 3; ++axis) {
        const Mat3d relative = toIndex * indexAxes(components[axis]->transform());
        if (!relative.eq(Mat3d::identity(), kTolerance)) {
            throw InputError(where + ": the components have different voxels; resample them onto one grid");
        }
    }
    const auto centres = first.copy();
    if (near(originOf(1), Vec3d(0)) && near(originOf(2), Vec3d(0))) {
        return {centres, components[0]->getGridClass() == openvdb::GRID_STAGGERED};
    }
    if (near(originOf(1), Vec3d(0.5, -0.5, 0)) && near(originOf(2), Vec3d(0.5, 0, -0.5))) {
        centres->preTranslate(Vec3d(0.5, 0, 0));
        return {centres, true};
    }
    throw InputError(where +
                     ": the components' origins differ by other than half a voxel; resample them onto one grid");
}

/// Where a velocity joined from three components has values. Collocated: where any has. Staggered: where all have, for
/// each has a layer of faces more along its own axis; but a component without any voxel was dropped for being 0.
void setTopology(Vec3SGrid& vectors, const Components& components, bool staggered, const std::string& where)
{
    for (const auto& component : components)
        vectors.tree().topologyUnion(component->tree());
    if (staggered) {
        for (const auto& component : components) {
            if (!component->empty()) vectors.tree().topologyIntersection(component->tree());
        }
    }
    checkVoxels(vectors.tree().activeVoxelCount(), where);
    vectors.tree().voxelizeActiveTiles();
}

VelocityGrid joined(const Components& components, const std::string& name, const std::string& where)
{
    const Layout layout = layoutOf(components, where);
    const auto vectors = Vec3SGrid::create(Vec3f(0));
    setTopology(*vectors, components, layout.staggered, where);
    vectors->setTransform(layout.centres);
    for (auto meta = components[0]->beginMeta(); meta != components[0]->endMeta(); ++meta) {
        if (meta->first == "time" || meta->first == "dt") vectors->insertMeta(meta->first, *meta->second);
    }
    openvdb::tree::LeafManager<openvdb::Vec3STree> leaves(vectors->tree());
    leaves.foreach ([&](openvdb::Vec3STree::LeafNodeType& leaf, std::size_t) {
        const std::array<FloatGrid::ConstAccessor, 3> sources = {
            components[0]->getConstAccessor(), components[1]->getConstAccessor(), components[2]->getConstAccessor()};
        for (auto value = leaf.beginValueOn(); value; ++value) {
            Vec3f vector(0);
            for (int axis = 0; axis < 3; ++axis) {
                const auto& source = sources[std::size_t(axis)];
                float near = 0, far = 0;
                if (!source.probeValue(value.getCoord(), near)) near = 0;
                Coord next = value.getCoord();
                ++next[axis];
                const bool average = layout.staggered && source.probeValue(next, far);
                vector[axis] = average ? 0.5f * (near + far) : near;
            }
            value.setValue(vector);
        }
    });
    return {name, vectors, layout.staggered};
}

/// Staggered components of a vector grid live on the faces at index − ½; a centre's value is the mean of its two faces.
Vec3SGrid::Ptr collocated(const Vec3SGrid& faces, const std::string& where)
{
    checkVoxels(faces.tree().activeVoxelCount(), where);
    auto centres = faces.deepCopy();
    centres->setGridClass(openvdb::GRID_UNKNOWN);
    centres->tree().voxelizeActiveTiles();
    openvdb::tree::LeafManager<openvdb::Vec3STree> leaves(centres->tree());
    leaves.foreach ([&](openvdb::Vec3STree::LeafNodeType& leaf, std::size_t) {
        const auto values = faces.getConstAccessor();
        for (auto value = leaf.beginValueOn(); value; ++value) {
            Vec3f mean = *value;
            for (int axis = 0; axis < 3; ++axis) {
                Coord next = value.getCoord();
                ++next[axis];
                Vec3f face;
                if (values.probeValue(next, face)) mean[axis] = 0.5f * (mean[axis] + face[axis]);
            }
            value.setValue(mean);
        }
    });
    return centres;
}

} // namespace

Mat3d indexAxes(const openvdb::math::Transform& transform)
{
    Mat3d columns;
    for (int axis = 0; axis < 3; ++axis) {
        Vec3d unit(0);
        unit[axis] = 1;
        columns.setCol(axis, transform.baseMap()->applyJacobian(unit));
    }
    return columns;
}

std::vector<std::string> velocityNames(const VdbFile& file)
{
    std::vector<std::string> names;
    std::string ignored;
    for (const char* name : kNames) {
        if (gridOf(file, name, isVector)) names.emplace_back(name);
    }
    for (const char* name : kNames) {
        if (scalarsOf(file, name, ignored)[0] && !gridOf(file, name, isVector)) names.emplace_back(name);
    }
    if (!names.empty()) return names;
    for (const auto& grid : file.grids) {
        if (isVector(grid)) names.push_back(grid->getName());
    }
    return names;
}

VelocityGrid findVelocity(const VdbFile& file, const std::string& name, const std::string& path)
{
    if (const auto grid = gridOf(file, name, isVector)) {
        const std::string where = fmt::format("{}: grid {}", path, name);
        checkTransform(*grid, where);
        const Vec3SGrid::Ptr vectors = asVectors(grid);
        const bool staggered = vectors->getGridClass() == openvdb::GRID_STAGGERED;
        return {name, staggered ? collocated(*vectors, where) : vectors, staggered};
    }
    std::string fullName;
    const auto scalars = scalarsOf(file, name, fullName);
    if (!scalars[0]) throw file.missing(fmt::format("velocity '{}'", name), "`velocity`");
    const std::string where = fmt::format("{}: grids {}", path, fullName);
    for (const auto& grid : scalars)
        checkTransform(*grid, where);
    return joined({asScalars(scalars[0]), asScalars(scalars[1]), asScalars(scalars[2])}, fullName, where);
}

} // namespace vdblic
