#pragma once

#include "vdblic/field/inlined.h"
#include "vdblic/field/leaf_box.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/period.h"

#include <openvdb/openvdb.h>
#include <tbb/parallel_for.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace vdblic {

/// The active voxels of one frame: its leaves in scan order, and the leaf that holds a voxel.
///
/// A leaf is OpenVDB's block of 8³ voxels. Leaves are numbered in the order in which every tree of this topology visits
/// them, so all grids on a domain share the numbering. Immutable; any number of threads may read.
///
/// Each of several processes that share the work knows the whole domain, computes its *own* leaves, and has values on
/// its *local* ones: its own and their neighbours. A process alone owns all.
class Domain {
  public:
    using Leaf = openvdb::MaskTree::LeafNodeType;
    using Mask = Leaf::NodeMaskType;
    static constexpr int kLeafVoxels = LeafVoxel::kCount;
    static_assert(Leaf::LOG2DIM == LeafVoxel::kLog2Dim);
    using Leaves = std::span<const std::uint32_t>; ///< numbers of leaves, ascending

    /// @param topology active voxels and OpenVDB tiles; tiles are expanded to voxels
    /// @param ranks    that share the voxels' values
    /// @param period   of a periodic box that has all the voxels
    /// @throws InputError if the voxels exceed the memory or the index range of the table of leaves
    explicit Domain(openvdb::MaskTree::Ptr topology, int ranks = 1, const Period& period = {});

    /// The same domain with other own and local leaves. @param own, local ascending; local ones include the own
    [[nodiscard]] std::shared_ptr<const Domain> ofRank(std::vector<std::uint32_t> own,
                                                       std::vector<std::uint32_t> local) const;
    [[nodiscard]] Leaves own() const { return mOwn; }
    [[nodiscard]] Leaves local() const { return mLocal; }
    [[nodiscard]] bool isOwn(std::size_t leaf) const { return mIsOwn.empty() || mIsOwn[leaf]; }
    [[nodiscard]] bool isWhole() const { return mIsOwn.empty(); } ///< whether all leaves are own ones

    [[nodiscard]] const openvdb::MaskTree& topology() const { return *mTopology; }
    [[nodiscard]] std::size_t leafCount() const { return mLeaves.size(); }
    [[nodiscard]] openvdb::Coord origin(std::size_t leaf) const { return mLeaves[leaf]->origin(); }
    [[nodiscard]] const Mask& mask(std::size_t leaf) const { return mLeaves[leaf]->getValueMask(); }
    [[nodiscard]] const LeafBox& box(std::size_t leaf) const { return mBoxes[leaf]; }
    [[nodiscard]] const Period& period() const { return mPeriod; }
    [[nodiscard]] std::size_t voxelCount() const { return mVoxelCount; } ///< of all leaves, own or not

    /// The number of a leaf's first voxel; offsets in the leaf give the others. Depends on the domain's voxels alone;
    /// below 2⁴³.
    [[nodiscard]] std::uint64_t firstVoxelNumber(std::size_t leaf) const;

    /// The number of the local leaf that covers a voxel, active or not; −1 if there is none. Outside a periodic box,
    /// the leaf that the voxel's image is in: offset() is the same in both.
    /// @param voxel an openvdb::Coord or any type with three coordinates
    template<typename Voxel>
    [[nodiscard]] VDBLIC_INLINE int findLeaf(const Voxel& voxel) const
    {
        const int leaf = leafAt(voxel);
        if (leaf >= 0 || !mIsPeriodic) [[likely]]
            return leaf;
        return leafOfImage({voxel[0], voxel[1], voxel[2]});
    }

    /// Index of a voxel among its leaf's values.
    template<typename Voxel>
    [[nodiscard]] VDBLIC_INLINE static unsigned offset(const Voxel& voxel)
    {
        return unsigned(LeafVoxel::offset(voxel[0], voxel[1], voxel[2]));
    }

    [[nodiscard]] VDBLIC_INLINE bool isActive(int leaf, unsigned offset) const
    {
        return mask(std::size_t(leaf)).isOn(offset);
    }

  private:
    /// findLeaf() without images.
    template<typename Voxel>
    [[nodiscard]] VDBLIC_INLINE int leafAt(const Voxel& voxel) const
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

    [[nodiscard]] int leafOfImage(const openvdb::Coord& voxel) const;
    void placeLeaves();
    [[nodiscard]] std::size_t blockIndex(const openvdb::Coord& voxel) const; // index in mBlocks

    openvdb::MaskTree::Ptr mTopology;
    Period mPeriod;
    bool mIsPeriodic;
    std::vector<const Leaf*> mLeaves;
    std::vector<LeafBox> mBoxes; // of the leaves
    std::vector<std::uint32_t> mOwn, mLocal;
    std::vector<std::uint8_t> mIsOwn; // of each leaf; empty if all are
    std::size_t mVoxelCount = 0;
    openvdb::Coord mFirstBlock;
    unsigned mBlockDim[3] = {0, 0, 0};
    std::vector<int> mBlocks;      // number of the block at a block coordinate, or −1
    std::vector<int> mLeafOfBlock; // of each block: numbers of its local leaves, or −1
};

/// A grid's values on leaves of a domain, in the domain's numbering, with direct access to each leaf. Copies share the
/// values.
template<typename T>
class LeafValues {
  public:
    using Tree = typename openvdb::tree::Tree4<T, 5, 4, 3>::Type;

    LeafValues() = default;
    /// Values on the local leaves.
    LeafValues(const Domain& domain, T value) : LeafValues(domain, value, domain.local()) {}
    /// Values on the leaves `on`: all equal to `value`; exactly the domain's voxels are active.
    LeafValues(const Domain& domain, T value, Domain::Leaves on)
        : mTree(std::make_shared<Tree>(value)), mData(domain.leafCount(), nullptr)
    {
        using Leaf = typename Tree::LeafNodeType;
        std::vector<std::unique_ptr<Leaf>> leaves(on.size());
        tbb::parallel_for(std::size_t(0), on.size(), [&](std::size_t i) {
            leaves[i] = std::make_unique<Leaf>(domain.origin(on[i]), value);
            leaves[i]->setValueMask(domain.mask(on[i]));
            mData[on[i]] = leaves[i]->buffer().data();
        });
        for (std::unique_ptr<Leaf>& leaf : leaves)
            mTree->addLeaf(leaf.release()); // takes ownership
    }

    /// The values of a tree. Its leaves are leaves of the domain, with the domain's active voxels.
    LeafValues(const Domain& domain, std::shared_ptr<Tree> tree)
        : mTree(std::move(tree)), mData(domain.leafCount(), nullptr)
    {
        for (std::size_t leaf = 0; leaf < mData.size(); ++leaf) {
            if (auto* const node = mTree->probeLeaf(domain.origin(leaf))) mData[leaf] = node->buffer().data();
        }
    }

    /// The 512 values of a leaf, x slowest; null if it has none here.
    [[nodiscard]] T* operator[](std::size_t leaf) { return mData[leaf]; }
    [[nodiscard]] const T* operator[](std::size_t leaf) const { return mData[leaf]; }
    [[nodiscard]] const std::shared_ptr<Tree>& tree() { return mTree; }
    [[nodiscard]] std::shared_ptr<const Tree> tree() const { return mTree; }

  private:
    std::shared_ptr<Tree> mTree;
    std::vector<T*> mData;
};

} // namespace vdblic
