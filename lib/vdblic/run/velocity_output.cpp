#include "vdblic/run/velocity_output.h"

#include "vdblic/field/for_leaves.h"
#include "vdblic/field/resample.h"

#include <openvdb/openvdb.h>
#include <openvdb/tree/LeafManager.h>

#include <array>
#include <cstddef>
#include <memory>

namespace vdblic {
namespace {

/// One component in world units per second, on a domain's voxels.
openvdb::FloatGrid::Ptr component(const Domain& domain, const openvdb::Vec3SGrid& velocities, int axis,
                                  const openvdb::Mat3d& unit, const VelocityMap& toWorld)
{
    const openvdb::Vec3d ofVelocity = (toWorld.ofVelocity * unit).row(axis), ofPlace = toWorld.ofPlace.row(axis);
    LeafValues<float> values(domain, 0.0f);
    forLeaves(domain.local(), [&](std::size_t leaf) {
        const openvdb::Vec3SGrid::ConstAccessor accessor = velocities.getConstAccessor();
        for (auto voxel = domain.mask(leaf).beginOn(); voxel; ++voxel) {
            const openvdb::Coord at = domain.origin(leaf) + Domain::Leaf::offsetToLocalCoord(voxel.pos());
            values[leaf][voxel.pos()] = float(ofVelocity.dot(openvdb::Vec3d(accessor.getValue(at))) +
                                              ofPlace.dot(velocities.indexToWorld(at)) + toWorld.constant[axis]);
        }
    });
    auto grid = openvdb::FloatGrid::create(values.tree());
    grid->setTransform(velocities.transform().copy());
    return grid;
}

} // namespace

openvdb::Vec3SGrid::Ptr velocityGrid(const Domain& domain, const openvdb::Vec3SGrid& velocities,
                                     const FromStored<Space::kWorld, Per::kSecond>& unit, const VelocityMap& toWorld,
                                     const openvdb::FloatGrid* like, GridPrecision precision)
{
    std::array<openvdb::FloatGrid::Ptr, 3> parts;
    bool isHalf = precision == GridPrecision::kHalf;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        parts[axis] = component(domain, velocities, int(axis), unit.matrix, toWorld);
        if (like) parts[axis] = resampled(*parts[axis], *like);
        saveAsHalf(*parts[axis]);
        isHalf = isHalf && parts[axis]->saveFloatAsHalf();
    }
    auto tree = std::make_shared<openvdb::Vec3STree>(parts[0]->tree(), openvdb::Vec3f(0), openvdb::TopologyCopy());
    openvdb::tree::LeafManager<openvdb::Vec3STree>(*tree).foreach (
        [&](openvdb::Vec3STree::LeafNodeType& leaf, std::size_t) {
            std::array<const openvdb::FloatTree::LeafNodeType*, 3> from{};
            for (std::size_t axis = 0; axis < 3; ++axis)
                from[axis] = parts[axis]->constTree().probeConstLeaf(leaf.origin());
            for (auto voxel = leaf.beginValueOn(); voxel; ++voxel) {
                const openvdb::Index at = voxel.pos();
                voxel.setValue({from[0]->getValue(at), from[1]->getValue(at), from[2]->getValue(at)});
            }
        });
    auto grid = openvdb::Vec3SGrid::create(tree);
    grid->setName(kVelocityGrid);
    grid->setTransform(parts[0]->transform().copy());
    grid->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
    grid->setSaveFloatAsHalf(isHalf);
    return grid;
}

} // namespace vdblic
