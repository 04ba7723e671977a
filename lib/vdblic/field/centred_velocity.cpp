#include "vdblic/field/centred_velocity.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/field/index_axes.h"

#include <fmt/format.h>
#include <openvdb/tree/LeafManager.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <memory>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Mat3d;
using openvdb::Vec3d;
using openvdb::Vec3f;
using openvdb::Vec3SGrid;
using Components = std::array<FloatGrid::ConstPtr, 3>;

// Many files have transforms that are products of floats.
constexpr double kTransformTolerance = 1e-4;

/// A double-precision grid in single precision; inactive values become 0.
template<typename Single, typename Double>
typename Single::Ptr narrowed(const Double& wide)
{
    using Value = typename Single::ValueType;
    auto tree =
        std::make_shared<typename Single::TreeType>(wide.tree(), openvdb::zeroVal<Value>(), openvdb::TopologyCopy());
    for (auto leaf = tree->beginLeaf(); leaf; ++leaf) {
        const auto* const source = wide.constTree().probeConstLeaf(leaf->origin());
        if (source->buffer().empty()) continue;
        for (auto value = leaf->beginValueOn(); value; ++value)
            value.setValue(Value(source->getValue(value.pos())));
    }
    auto tile = tree->beginValueOn();
    tile.setMaxDepth(tile.getLeafDepth() - 1);
    for (; tile; ++tile)
        tile.setValue(Value(wide.constTree().getValue(tile.getCoord())));
    auto grid = Single::create(tree);
    grid->insertMeta(wide); // copies name and class too
    grid->setTransform(wide.transform().copy());
    return grid;
}

/// A grid of either precision in single precision.
template<typename Single, typename Double>
typename Single::Ptr asSingle(const openvdb::GridBase::Ptr& grid)
{
    if (auto single = openvdb::gridPtrCast<Single>(grid)) return single;
    return narrowed<Single>(*openvdb::gridPtrCast<Double>(grid));
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
        if (std::abs(p.dot(q)) > kTransformTolerance * p.length() * q.length()) {
            throw InputError(where + " has a sheared transform; resample it onto a grid with right angles");
        }
    }
}

/// Where the three components are sampled.
struct Sampling {
    openvdb::math::Transform::Ptr centres; ///< transform of the voxel centres
    bool staggered = false;
};

/// Components on one transform are staggered if their class says so. Houdini gives each face-sampled component a
/// transform of its own, shifted by half a voxel along the component's axis.
Sampling samplingOf(const Components& components, const std::string& where)
{
    const openvdb::math::Transform& first = components[0]->transform();
    const Mat3d toIndex = indexAxes(first).inverse();
    const auto originOf = [&](std::size_t axis) {
        return toIndex * (components[axis]->transform().indexToWorld(Vec3d(0)) - first.indexToWorld(Vec3d(0)));
    };
    const auto near = [](const Vec3d& a, const Vec3d& b) { return (a - b).length() < 1e-2; };
    for (std::size_t axis = 1; axis < 3; ++axis) {
        const Mat3d relative = toIndex * indexAxes(components[axis]->transform());
        if (!relative.eq(Mat3d::identity(), kTransformTolerance)) {
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

/// The voxels of a velocity joined from three components: the union of collocated components, the intersection of
/// staggered ones, each of which has one more layer of faces along its own axis. A staggered component without any
/// voxel is 0 everywhere and was dropped by its writer.
openvdb::MaskTree topologyOf(const Components& components, bool staggered)
{
    openvdb::MaskTree topology;
    for (const auto& component : components)
        topology.topologyUnion(component->tree());
    if (staggered) {
        for (const auto& component : components) {
            if (!component->empty()) topology.topologyIntersection(component->tree());
        }
    }
    return topology;
}

/// Set the active voxels of a grid to the values of their components at the voxel centres.
/// @param box whose leaves are set  @param makeProbe makes, once per leaf, a callable (axis, index, value) → whether
/// the component is active there
template<typename MakeProbe>
void setCentres(Vec3SGrid& centres, bool staggered, const std::optional<openvdb::CoordBBox>& box,
                const MakeProbe& makeProbe)
{
    openvdb::tree::LeafManager<openvdb::Vec3STree> leaves(centres.tree());
    leaves.foreach ([&](openvdb::Vec3STree::LeafNodeType& leaf, std::size_t) {
        if (box && !box->isInside(leaf.origin())) return;
        const auto probe = makeProbe();
        for (auto value = leaf.beginValueOn(); value; ++value) {
            Vec3f centre(0);
            for (int axis = 0; axis < 3; ++axis) {
                float near = 0, far = 0;
                if (!probe(axis, value.getCoord(), near)) near = 0;
                Coord next = value.getCoord();
                ++next[axis];
                centre[axis] = staggered && probe(axis, next, far) ? 0.5f * (near + far) : near;
            }
            value.setValue(centre);
        }
    });
}

Vec3SGrid::Ptr joined(const Components& components, const std::string& where,
                      const std::optional<openvdb::CoordBBox>& box)
{
    const Sampling sampling = samplingOf(components, where);
    openvdb::MaskTree topology = topologyOf(components, sampling.staggered);
    if (!box) checkVoxels(topology.activeVoxelCount(), where, 1, topology.activeLeafVoxelCount());
    topology.voxelizeActiveTiles();
    const auto vectors = zeroVelocity(topology, box);
    vectors->setTransform(sampling.centres);
    for (auto meta = components[0]->beginMeta(); meta != components[0]->endMeta(); ++meta) {
        if (meta->first == "time" || meta->first == "dt") vectors->insertMeta(meta->first, *meta->second);
    }
    setCentres(*vectors, sampling.staggered, box, [&] {
        return [sources = std::array{components[0]->getConstAccessor(), components[1]->getConstAccessor(),
                                     components[2]->getConstAccessor()}](int axis, const Coord& at, float& value) {
            return sources[std::size_t(axis)].probeValue(at, value);
        };
    });
    return vectors;
}

/// A staggered vector grid, whose components live on the faces at index − ½, on the voxel centres.
Vec3SGrid::Ptr collocated(const Vec3SGrid& faces, const std::string& where,
                          const std::optional<openvdb::CoordBBox>& box)
{
    if (!box) checkVoxels(faces.tree().activeVoxelCount(), where, 1, faces.tree().activeLeafVoxelCount());
    auto centres = faces.deepCopy();
    centres->setGridClass(openvdb::GRID_UNKNOWN);
    centres->tree().voxelizeActiveTiles();
    setCentres(*centres, true, box, [&] {
        return [source = faces.getConstAccessor()](int axis, const Coord& at, float& value) {
            Vec3f face;
            const bool active = source.probeValue(at, face);
            value = face[axis];
            return active;
        };
    });
    return centres;
}

} // namespace

Vec3SGrid::Ptr centredVelocity(const VelocityGrids& found, const std::string& path,
                               const std::optional<openvdb::CoordBBox>& box)
{
    const bool vectors = found.values.size() == 1;
    const std::string where = fmt::format("{}: {} {}", path, vectors ? "grid" : "grids", found.name);
    for (const auto& grid : found.values)
        checkTransform(*grid, where);
    if (vectors) {
        const auto grid = asSingle<Vec3SGrid, openvdb::Vec3DGrid>(found.values.front());
        return grid->getGridClass() == openvdb::GRID_STAGGERED ? collocated(*grid, where, box) : grid;
    }
    const auto component = [&](std::size_t axis) {
        return asSingle<FloatGrid, openvdb::DoubleGrid>(found.values[axis]);
    };
    return joined({component(0), component(1), component(2)}, where, box);
}

Vec3SGrid::Ptr zeroVelocity(const openvdb::MaskTree& topology, const std::optional<openvdb::CoordBBox>& box)
{
    if (!box)
        return Vec3SGrid::create(std::make_shared<openvdb::Vec3STree>(topology, Vec3f(0), openvdb::TopologyCopy()));
    using Leaf = openvdb::Vec3STree::LeafNodeType;
    auto grid = Vec3SGrid::create(Vec3f(0));
    for (auto mask = topology.cbeginLeaf(); mask; ++mask) {
        auto leaf = box->isInside(mask->origin())
                        ? std::make_unique<Leaf>(*mask, Vec3f(0), openvdb::TopologyCopy())
                        : std::make_unique<Leaf>(openvdb::PartialCreate(), mask->origin(), Vec3f(0));
        leaf->setValueMask(mask->getValueMask());
        grid->tree().addLeaf(leaf.release()); // takes ownership
    }
    return grid;
}

} // namespace vdblic
