#pragma once

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <memory>
#include <vector>

namespace vdblic {

/// The active voxels of one frame: its leaves in scan order, and the leaf that holds a voxel.
///
/// A leaf is OpenVDB's block of 8³ voxels. Leaves are numbered in the order in which every tree of this topology visits
/// them, so all grids on a domain share the numbering. Immutable; any number of threads may read.
class Domain {
  public:
    using Leaf = openvdb::MaskTree::LeafNodeType;
    using Mask = Leaf::NodeMaskType;
    static constexpr int kLeafVoxels = LeafVoxel::kCount;
    static_assert(Leaf::LOG2DIM == LeafVoxel::kLog2Dim);

    /// @param topology active voxels and OpenVDB tiles; tiles are expanded to voxels
    /// @throws InputError if the voxels spread over more index space than the table of leaves spans, or exceed the
    ///         memory
    explicit Domain(openvdb::MaskTree::Ptr topology);

    [[nodiscard]] const openvdb::MaskTree& topology() const { return *mTopology; }
    [[nodiscard]] std::size_t leafCount() const { return mLeaves.size(); }
    [[nodiscard]] openvdb::Coord origin(std::size_t leaf) const { return mLeaves[leaf]->origin(); }
    [[nodiscard]] const Mask& mask(std::size_t leaf) const { return mLeaves[leaf]->getValueMask(); }
    [[nodiscard]] std::size_t voxelCount() const { return mVoxelCount; }

    /// The number of the leaf that covers a voxel, active or not; −1 if there is none.
    [[nodiscard]] VDBLIC_INLINE int findLeaf(Int4 voxel) const
    {
        const auto x = unsigned((voxel[0] >> LeafBlock::kLog2Voxels) - mFirstBlock[0]);
        const auto y = unsigned((voxel[1] >> LeafBlock::kLog2Voxels) - mFirstBlock[1]);
        const auto z = unsigned((voxel[2] >> LeafBlock::kLog2Voxels) - mFirstBlock[2]);
        if (x >= mBlockDim[0] || y >= mBlockDim[1] || z >= mBlockDim[2]) return -1;
        const int block = mBlocks[(std::size_t(x) * mBlockDim[1] + y) * mBlockDim[2] + z];
        if (block < 0) return -1;
        const int leafIndex = LeafBlock::leafIndex(voxel[0], voxel[1], voxel[2]);
        return mLeafOfBlock[std::size_t(block) * LeafBlock::kCount + std::size_t(leafIndex)];
    }

    /// Index of a voxel among its leaf's values.
    [[nodiscard]] VDBLIC_INLINE static unsigned offset(Int4 voxel)
    {
        return unsigned(LeafVoxel::offset(voxel[0], voxel[1], voxel[2]));
    }

    [[nodiscard]] VDBLIC_INLINE bool isActive(int leaf, unsigned offset) const
    {
        return mask(std::size_t(leaf)).isOn(offset);
    }

    /// Whether a position, in index space, lies in an active voxel.
    [[nodiscard]] VDBLIC_INLINE bool contains(Float4 position) const
    {
        const Int4 voxel = voxelOf(position);
        const int leaf = findLeaf(voxel);
        return leaf >= 0 && isActive(leaf, offset(voxel));
    }

  private:
    openvdb::MaskTree::Ptr mTopology;
    std::vector<const Leaf*> mLeaves;
    std::size_t mVoxelCount = 0;
    openvdb::Coord mFirstBlock;
    unsigned mBlockDim[3] = {0, 0, 0};
    std::vector<int> mBlocks;      // number of the block at a block coordinate, or −1
    std::vector<int> mLeafOfBlock; // of each block: numbers of its leaves, or −1
};

/// A grid's values on the leaves of a domain, in the domain's numbering, with direct access to each leaf.
template<typename T>
class LeafValues {
  public:
    using Tree = typename openvdb::tree::Tree4<T, 5, 4, 3>::Type;

    LeafValues() = default;
    /// Every voxel of every leaf starts with `value`; exactly the domain's voxels are active.
    LeafValues(const Domain& domain, T value)
        : mTree(std::make_shared<Tree>(domain.topology(), value, openvdb::TopologyCopy()))
    {
        std::vector<typename Tree::LeafNodeType*> leaves;
        leaves.reserve(domain.leafCount());
        mTree->getNodes(leaves);
        mData.reserve(leaves.size());
        for (auto* leaf : leaves)
            mData.push_back(leaf->buffer().data());
    }

    /// The 512 values of a leaf, x slowest.
    [[nodiscard]] T* operator[](std::size_t leaf) const { return mData[leaf]; }
    [[nodiscard]] const std::shared_ptr<Tree>& tree() const { return mTree; }

  private:
    std::shared_ptr<Tree> mTree;
    std::vector<T*> mData;
};

} // namespace vdblic
