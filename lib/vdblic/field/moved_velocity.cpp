#include "vdblic/field/moved_velocity.h"

#include "vdblic/core/memory.h"
#include "vdblic/core/paging.h"
#include "vdblic/field/centred_velocity.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/trilinear.h"

#include <openvdb/tools/Prune.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <cstddef>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::MaskTree;
using openvdb::Vec3d;

/// The leaves that may have voxels of the result, all inactive.
MaskTree leavesAround(const MaskTree& source, const IndexMap& toSource)
{
    const openvdb::Mat3d matrix = toSource.matrix.inverse();
    const IndexMap fromSource{matrix, -(matrix * toSource.shift)};
    MaskTree leaves;
    openvdb::tree::ValueAccessor<MaskTree> accessor(leaves);
    for (auto leaf = source.cbeginLeaf(); leaf; ++leaf) {
        const CoordBBox box = fromSource.around(leaf->getNodeBoundingBox());
        const Coord first = box.min() & ~(LeafVoxel::kDim - 1);
        for (Coord at = first; at[0] <= box.max()[0]; at[0] += LeafVoxel::kDim) {
            for (at[1] = first[1]; at[1] <= box.max()[1]; at[1] += LeafVoxel::kDim) {
                for (at[2] = first[2]; at[2] <= box.max()[2]; at[2] += LeafVoxel::kDim)
                    accessor.touchLeaf(at);
            }
        }
    }
    return leaves;
}

/// The voxel at a position. Positions half way between two voxels, which are often rounded, all choose alike.
Coord nearest(const Vec3d& position)
{
    constexpr double kRounding = 1e-6;
    return Coord::floor(position + 0.5 + kRounding);
}

} // namespace

CoordBBox IndexMap::around(const CoordBBox& box) const
{
    constexpr double kFarthest = 1 << 30;
    openvdb::BBoxd places;
    for (int corner = 0; corner < 8; ++corner) {
        const auto end = [&](int axis) { return (corner >> axis & 1 ? box.max() : box.min())[axis]; };
        places.expand(at(Vec3d(end(0), end(1), end(2))));
    }
    const auto clamped = [](const Vec3d& place) {
        return openvdb::math::minComponent(openvdb::math::maxComponent(place, Vec3d(-kFarthest)), Vec3d(kFarthest));
    };
    return {Coord::floor(clamped(places.min() - 1.0)), Coord::ceil(clamped(places.max() + 1.0))};
}

openvdb::Vec3SGrid::Ptr movedVelocity(const openvdb::Vec3SGrid& values, const IndexMap& toSource,
                                      const std::optional<CoordBBox>& box)
{
    const openvdb::Vec3STree& tree = values.tree();
    if (!box) checkVoxels(tree.activeVoxelCount(), "", 1, tree.activeLeafVoxelCount());
    MaskTree source(tree, false, true, openvdb::TopologyCopy());
    source.voxelizeActiveTiles();
    MaskTree topology = leavesAround(source, toSource);
    openvdb::tree::LeafManager<MaskTree>(topology).foreach ([&](MaskTree::LeafNodeType& leaf, std::size_t) {
        const openvdb::tree::ValueAccessor<const MaskTree> accessor(source);
        for (openvdb::Index voxel = 0; voxel < MaskTree::LeafNodeType::SIZE; ++voxel) {
            const Vec3d place = toSource.at(leaf.offsetToGlobalCoord(voxel).asVec3d());
            if (accessor.isValueOn(nearest(place))) leaf.setValueOn(voxel);
        }
    });
    openvdb::tools::pruneInactive(topology);
    auto moved = zeroVelocity(topology, box);
    moved->insertMeta(values);
    moved->setTransform(values.transform().copy());
    using Leaf = openvdb::Vec3STree::LeafNodeType;
    openvdb::tree::LeafManager<openvdb::Vec3STree>(moved->tree()).foreach ([&](Leaf& leaf, std::size_t) {
        if (leaf.buffer().empty()) return;
        paging::breathe(paging::kLeafBytes);
        const openvdb::Vec3SGrid::ConstAccessor accessor = values.getConstAccessor();
        for (auto voxel = leaf.beginValueOn(); voxel; ++voxel)
            voxel.setValue(valueAt(accessor, toSource.at(voxel.getCoord().asVec3d())));
    });
    return moved;
}

} // namespace vdblic
