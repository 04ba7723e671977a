#pragma once

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

struct Look;
class TextureVolume;

/// Where samples can be visible, looked up by position: the tables behind empty-space skipping.
///
/// Space is cut into blocks of 16³ leaves. Only a block with a visible leaf has a table, with an entry for each of its
/// leaves. Visible leaves know of each cell between voxels' centres whether a sample in it can be visible, or how far
/// the next such cell is: a distance field (Zuiderveld, Koning & Viergever 1992). Voxel coordinates are index space
/// relative to origin(), which is below every leaf: they are never negative. Immutable; any number of threads may read.
class VisibleSpace {
  public:
    static constexpr int kMostDistance = 15; ///< distances are told up to this

    /// @param farthest distance that is told, at least 1: the shorter, the more samples in empty space are looked at
    VisibleSpace(const TextureVolume& volume, const Look& look, int farthest = kMostDistance);

    static constexpr int kBlockDim = 1 << LeafBlock::kLog2Voxels; ///< in voxels
    static constexpr int kNoBlock = 0; ///< table that all blocks without a visible leaf share
    // Flags of an entry.
    static constexpr int kNothingBit = 0; ///< the leaf does not exist or is not visible
    static constexpr int kPartlyBit = 1;  ///< the leaf has voxels that are not shown

    /// The table of the block that holds a voxel.
    [[nodiscard]] int findBlock(int x, int y, int z) const
    {
        x /= kBlockDim;
        y /= kBlockDim;
        z /= kBlockDim;
        return x < mDim[0] && y < mDim[1] && z < mDim[2] ? mBlocks[blockIndex(x, y, z)] : kNoBlock;
    }
    /// Entries of the leaves that hold eight voxels. @param blocks tables of the voxels' blocks
    [[nodiscard]] VDBLIC_INLINE Unsigned8 findLeaves(Int8 blocks, const Int8* voxel) const
    {
        std::uint32_t at[kLanes];
        storeLanes(Unsigned8(blocks * LeafBlock::kCount + LeafBlock::leafIndex(voxel[0], voxel[1], voxel[2])), at);
        Unsigned8 entries;
        for (int lane = 0; lane < kLanes; ++lane)
            entries[lane] = mLeaves[at[lane]];
        return entries;
    }
    /// Lanes whose entries have a flag are negative.
    [[nodiscard]] VDBLIC_INLINE static Int8 flagged(Unsigned8 entries, int bit) { return Int8(entries << (31 - bit)); }
    /// The numbers of entries' leaves; 0 for those without.
    [[nodiscard]] VDBLIC_INLINE static Unsigned8 leafOf(Unsigned8 entries)
    {
        return flagged(entries, kNothingBit) < 0 ? Unsigned8{} : entries >> kNumberShift;
    }

    /// How many cells away the next visible cell of the same block is, along the axis where it is farthest; 0: a
    /// visible cell. Without a visible leaf it counts from the leaf's outermost cells.
    /// @param cell the cells' lowest corners, relative to the first voxel of the leaves, from −1 to 7
    [[nodiscard]] VDBLIC_INLINE Int8 findDistances(Unsigned8 entries, const Int8* cell) const
    {
        if (!anyOf(Int8(~entries & kWhole) != 0)) return Int8{};
        const auto index = Unsigned8(((cell[0] + 1) * kCells + cell[1] + 1) * kCells + cell[2] + 1);
        std::uint32_t at[kLanes];
        storeLanes(leafOf(entries) * kCellCount + index, at);
        Int8 distances;
        for (int lane = 0; lane < kLanes; ++lane)
            distances[lane] = mDistances[at[lane]];
        return flagged(entries, kNothingBit) < 0 ? Int8(entries >> kNumberShift) : distances;
    }
    [[nodiscard]] const openvdb::Coord& origin() const { return mOrigin; }

    static constexpr int kCells = LeafVoxel::kDim + 1; ///< that voxels of a leaf touch, along an axis
    static constexpr int kCellCount = kCells * kCells * kCells;
    /// Memory that a leaf takes while the tables are made.
    static constexpr std::size_t kBytesPerLeaf = kCellCount + sizeof(std::uint16_t) * kCells * kCells;

  private:
    // An entry is a leaf's number above its flags; without a leaf a distance.
    static constexpr unsigned kNothing = 1 << kNothingBit, kPartly = 1 << kPartlyBit;
    static constexpr unsigned kWhole = 4; // another flag: every cell is visible
    static constexpr int kNumberShift = 3;

    struct LeafCells;
    class BlockCells;

    static LeafCells visibleCells(const TextureVolume& volume, const Look& look, std::size_t leaf);
    void measure(const TextureVolume& volume, const std::vector<LeafCells>& cells,
                 const std::vector<std::uint32_t>& leaves, int farthest, int block);
    [[nodiscard]] std::size_t blockIndex(int x, int y, int z) const
    {
        return (std::size_t(x) * unsigned(mDim[1]) + unsigned(y)) * unsigned(mDim[2]) + unsigned(z);
    }

    openvdb::Coord mOrigin{0};
    int mDim[3] = {0, 0, 0};              // in blocks
    std::vector<int> mBlocks;             // number of each block's table
    std::vector<std::uint32_t> mLeaves;   // all tables
    std::vector<std::uint8_t> mDistances; // by leaf and cell; of visible leaves
};

} // namespace vdblic
