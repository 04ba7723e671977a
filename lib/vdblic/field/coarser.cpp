#include "vdblic/field/coarser.h"

#include "vdblic/core/memory.h"
#include "vdblic/core/paging.h"

#include <openvdb/tools/Prune.h>
#include <openvdb/tree/LeafManager.h>

#include <array>
#include <cstddef>
#include <type_traits>

namespace vdblic {
namespace {

/// The downsampling of a grid.
struct CoarserRule {
    bool isStaggered, countsEmpty;
};

/// The mean of a component over the finer voxels of a coarser one. @return whether one of them is active
template<typename Leaf, typename Number>
bool meanOver(const Leaf& fine, const openvdb::Coord& first, int component, const CoarserRule& rule, Number& mean)
{
    using Value = typename Leaf::ValueType;
    constexpr int kComponents = openvdb::VecTraits<Value>::Size;
    std::array<int, 3> count{2, 2, 2};
    if (rule.isStaggered) count[std::size_t(component)] = 1;
    const auto* const numbers = reinterpret_cast<const Number*>(fine.buffer().data());
    Number sum = 0;
    int active = 0;
    for (int z = 0; z < count[2]; ++z) { // in an order that rounds alike along all axes
        Number sumOfRow = 0;
        for (int y = 0; y < count[1]; ++y) {
            Number sumOfPair = 0;
            for (int x = 0; x < count[0]; ++x) {
                const openvdb::Index voxel = Leaf::coordToOffset(first.offsetBy(x, y, z));
                if (!fine.isValueOn(voxel)) continue;
                sumOfPair += numbers[int(voxel) * kComponents + component];
                ++active;
            }
            sumOfRow += sumOfPair;
        }
        sum += sumOfRow;
    }
    if (active == 0) return false;
    mean = sum / Number(rule.countsEmpty ? count[0] * count[1] * count[2] : active);
    return true;
}

/// Fill the part of a leaf that lies over a finer one.
template<typename Fine, typename Leaf>
void fillFrom(const Fine& fine, const CoarserRule& rule, Leaf& leaf)
{
    using Number = typename openvdb::VecTraits<typename Fine::ValueType>::ElementType;
    using Value = typename Leaf::ValueType;
    constexpr int kComponents = openvdb::VecTraits<Value>::Size, kHalf = int(Fine::DIM) / 2;
    const openvdb::CoordBBox part = openvdb::CoordBBox::createCube(fine.origin() >> 1, kHalf);
    for (auto voxel = part.begin(); voxel; ++voxel) {
        std::array<float, kComponents> means{};
        bool isActive = false;
        for (int i = 0; i < kComponents; ++i) {
            Number mean = 0;
            if (!meanOver(fine, *voxel << 1, i, rule, mean)) continue;
            means[std::size_t(i)] = float(mean);
            isActive = true;
        }
        if (!isActive) continue;
        if constexpr (kComponents == 1) {
            leaf.setValueOn(*voxel, means[0]);
        } else {
            leaf.setValueOn(*voxel, Value(means.data()));
        }
    }
}

template<typename GridT>
openvdb::GridBase::Ptr coarserOf(const GridT& grid, const CoarserRule& rule)
{
    using Fine = typename GridT::TreeType::LeafNodeType;
    using Coarse = std::conditional_t<openvdb::VecTraits<typename GridT::ValueType>::IsVec, openvdb::Vec3SGrid,
                                      openvdb::FloatGrid>;
    openvdb::MaskTree topology(grid.tree(), false, openvdb::TopologyCopy());
    checkVoxels(topology.activeVoxelCount(), "", 1, topology.activeLeafVoxelCount());
    topology.voxelizeActiveTiles();
    const auto result = Coarse::create();
    for (auto leaf = topology.cbeginLeaf(); leaf; ++leaf)
        result->tree().touchLeaf(leaf->origin() >> 1);
    openvdb::tree::LeafManager<typename Coarse::TreeType> leaves(result->tree());
    leaves.foreach ([&](auto& leaf, std::size_t) {
        constexpr int kDim = Fine::DIM;
        const auto finer = grid.getConstUnsafeAccessor();
        for (int n = 0; n < 8; ++n) {
            paging::breathe(paging::kLeafBytes);
            const openvdb::Coord first =
                (leaf.origin() << 1).offsetBy((n >> 2) * kDim, (n >> 1 & 1) * kDim, (n & 1) * kDim);
            if (const Fine* const fine = finer.probeConstLeaf(first)) {
                fillFrom(*fine, rule, leaf);
            } else if (finer.isValueOn(first)) {
                fillFrom(Fine(first, finer.getValue(first), true), rule, leaf);
            }
        }
    });
    openvdb::tools::pruneInactive(result->tree());
    result->insertMeta(grid);
    const auto transform = grid.transform().copy();
    transform->preTranslate(openvdb::Vec3d(0.5));
    transform->preScale(2.0);
    result->setTransform(transform);
    return result;
}

} // namespace

openvdb::GridBase::Ptr coarser(const openvdb::GridBase& grid, bool countsEmpty)
{
    using Numbers = openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Vec3SGrid, openvdb::Vec3DGrid>;
    const CoarserRule rule{grid.getGridClass() == openvdb::GRID_STAGGERED, countsEmpty};
    openvdb::GridBase::Ptr result;
    grid.apply<Numbers>([&](const auto& typed) { result = coarserOf(typed, rule); });
    return result;
}

} // namespace vdblic
