#pragma once

#include "vdblic/field/vector.h"

#include <openvdb/openvdb.h>

#include <array>
#include <vector>

namespace vdblic {

/// The active voxels of one frame: its leaves in scan order, and which leaf holds a voxel.
///
/// A leaf is OpenVDB's block of 8³ voxels. Leaves are numbered in the order every tree of this topology
/// visits them, so grids made on a domain share the numbering. Immutable; any number of threads may read.
class Domain {
  public:
    using Leaf = openvdb::MaskTree::LeafNodeType;
    using Mask = Leaf::NodeMaskType;
    static constexpr int kLeafVoxels = Leaf::SIZE;

    /// @param topology its active voxels and tiles; tiles are expanded to voxels
    /// @throws InputError if the voxels spread over more index space than the leaf index spans, or exceed the memory
    explicit Domain(openvdb::MaskTree::Ptr topology);

    [[nodiscard]] const openvdb::MaskTree& topology() const { return *mTopology; }
    [[nodiscard]] std::size_t leafCount() const { return mLeaves.size(); }
    [[nodiscard]] openvdb::Coord origin(std::size_t leaf) const { return mLeaves[leaf]->origin(); }
    [[nodiscard]] const Mask& mask(std::size_t leaf) const { return mLeaves[leaf]->getValueMask(); }
    [[nodiscard]] std::size_t voxelCount() const { return mVoxelCount; }

    /// The number of the leaf that covers a voxel, active or not; −1 if there is none.
    [[nodiscard]] VDBLIC_INLINE int findLeaf(Int4 voxel) const
    {
        const unsigned x = unsigned((voxel[0] >> kBlockShift) - mFirstBlock[0]);
        const unsigned y = unsigned((voxel[1] >> kBlockShift) - mFirstBlock[1]);
        const unsigned z = unsigned((voxel[2] >> kBlockShift) - mFirstBlock[2]);
        if (x >= mBlockDim[0] || y >= mBlockDim[1] || z >= mBlockDim[2]) return -1;
        const int block = mBlocks[(std::size_t(x) * mBlockDim[1] + y) * mBlockDim[2] + z];
        if (block < 0) return -1;
        const int inBlock = ((voxel[0] >> 3) & 15) << 8 | ((voxel[1] >> 3) & 15) << 4 | ((voxel[2] >> 3) & 15);
        return mLeafOfBlock[std::size_t(block) * kBlockLeaves + std::size_t(inBlock)];
    }

    /// Where a voxel stands among its leaf's values.
    [[nodiscard]] VDBLIC_INLINE static unsigned offset(Int4 voxel)
    {
        return unsigned((voxel[0] & 7) << 6 | (voxel[1] & 7) << 3 | (voxel[2] & 7));
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
    static constexpr int kBlockShift = 7; // blocks of 16³ leaves, as OpenVDB's lower internal nodes
    static constexpr std::size_t kBlockLeaves = 4096;

    openvdb::MaskTree::Ptr mTopology;
    std::vector<const Leaf*> mLeaves;
    std::size_t mVoxelCount = 0;
    openvdb::Coord mFirstBlock;
    unsigned mBlockDim[3] = {0, 0, 0};
    std::vector<int> mBlocks;      // number of the block at a block coordinate, or −1
    std::vector<int> mLeafOfBlock; // number of the leaf at a place in a block, or −1
};

/// A leaf and the 26 around it: finds the leaves of eight voxels at once.
///
/// Places in the window count from 0 to 26, x slowest; kCentre is the leaf itself, kElsewhere what lies outside the
/// window.
struct LeafWindow {
    static constexpr int kCentre = 13, kElsewhere = 27;

    int first[3] = {1 << 20, 1 << 20, 1 << 20}; ///< of the window, in leaves; by default everything is elsewhere
    std::array<int, 28> leaves;                 ///< numbers of the leaves at each place; −1 where there is none

    LeafWindow() { leaves.fill(-1); }
    LeafWindow(const Domain& domain, const openvdb::Coord& origin)
    {
        for (int axis = 0; axis < 3; ++axis)
            first[axis] = (origin[axis] >> 3) - 1;
        for (int place = 0; place < kElsewhere; ++place) {
            const openvdb::Coord there = originOf(place);
            leaves[std::size_t(place)] = domain.findLeaf(Int4{there[0], there[1], there[2], 0});
        }
        leaves[kElsewhere] = -1;
    }

    [[nodiscard]] openvdb::Coord originOf(int place) const
    {
        return {(first[0] + place / 9) << 3, (first[1] + place / 3 % 3) << 3, (first[2] + place % 3) << 3};
    }

    /// The places of eight voxels.
    [[nodiscard]] VDBLIC_INLINE Int8 place(Int8 x, Int8 y, Int8 z) const
    {
        const Int8 i = (x >> 3) - first[0], j = (y >> 3) - first[1], k = (z >> 3) - first[2];
        const auto a = Unsigned8(i), b = Unsigned8(j), c = Unsigned8(k); // what is far away may wrap around
        const Int8 elsewhere = Int8((a > 2u) | (b > 2u) | (c > 2u));
        const auto inside = Int8((a << 3) + a + (b << 1) + b + c);
        return elsewhere ? Int8{} + kElsewhere : inside;
    }
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
