#include "vdblic/field/resample.h"

#include "vdblic/field/trilinear.h"

#include <openvdb/tree/LeafManager.h>

#include <cstddef>
#include <memory>

namespace vdblic {

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
