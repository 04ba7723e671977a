#include "vdblic/field/resample.h"

#include <openvdb/tree/LeafManager.h>

#include <cstddef>
#include <memory>

namespace vdblic {
namespace {

/// @param position in the index space of the values
float valueAt(const openvdb::FloatGrid::ConstAccessor& values, const openvdb::Vec3d& position)
{
    const openvdb::Coord base = openvdb::Coord::floor(position);
    const openvdb::Vec3d fraction = position - base.asVec3d();
    double sum = 0, weights = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const openvdb::Coord step(corner >> 2, corner >> 1 & 1, corner & 1);
        float value = 0;
        if (!values.probeValue(base + step, value)) continue;
        double weight = 1;
        for (int axis = 0; axis < 3; ++axis)
            weight *= step[axis] ? fraction[axis] : 1 - fraction[axis];
        sum += weight * double(value);
        weights += weight;
    }
    return weights > 0 ? float(sum / weights) : 0;
}

} // namespace

openvdb::FloatGrid::Ptr resampled(const openvdb::FloatGrid& values, const openvdb::FloatGrid& like)
{
    using Leaf = openvdb::FloatTree::LeafNodeType;
    auto tree = std::make_shared<openvdb::FloatTree>(0.0f);
    for (auto leaf = like.tree().cbeginLeaf(); leaf; ++leaf) {
        if (!leaf->buffer().empty()) tree->addLeaf(new Leaf(*leaf, 0.0f, openvdb::TopologyCopy())); // takes it over
    }
    auto tile = like.tree().cbeginValueOn();
    tile.setMaxDepth(openvdb::FloatTree::ValueOnCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile)
        tree->fill(tile.getBoundingBox(), 0.0f);
    tree->voxelizeActiveTiles();
    openvdb::tree::LeafManager<openvdb::FloatTree> leaves(*tree);
    leaves.foreach ([&](Leaf& leaf, std::size_t) {
        const openvdb::FloatGrid::ConstAccessor accessor = values.getConstAccessor();
        for (auto voxel = leaf.beginValueOn(); voxel; ++voxel)
            voxel.setValue(valueAt(accessor, values.worldToIndex(like.indexToWorld(voxel.getCoord()))));
    });
    auto grid = openvdb::FloatGrid::create(tree);
    grid->insertMeta(values);
    grid->setTransform(like.transform().copy());
    return grid;
}

} // namespace vdblic
