#pragma once

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"
#include "vdblic/volume/texture_records.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

struct Look;
class TextureVolume;

/// The leaves that can contribute to a picture, looked up by position: the table behind empty-space skipping.
///
/// Space is cut into blocks of 16³ leaves. Only a block with a visible leaf has a table, with an entry for each of its
/// leaves. Voxel coordinates are index space relative to origin(), which is below every leaf: they are never negative.
/// Immutable; any number of threads may read.
class VisibleLeaves {
  public:
    /// @param visible for each of the volume's leaves: not 0 if it contributes
    VisibleLeaves(const TextureVolume& volume, const std::vector<std::uint8_t>& visible);
    VisibleLeaves(const TextureVolume& volume, const Look& look);

    static constexpr int kBlockDim = 1 << LeafBlock::kLog2Voxels; ///< in voxels
    static constexpr int kNoBlock = 0; ///< offset of the table that all blocks without a visible leaf share
    // Flags of an entry.
    static constexpr int kNothingBit = 0; ///< the leaf does not exist or is not visible
    static constexpr int kPartlyBit = 1;  ///< some of the leaf's voxels are not shown

    /// Offset of the table of the block that holds a voxel.
    [[nodiscard]] int findBlock(int x, int y, int z) const
    {
        x /= kBlockDim;
        y /= kBlockDim;
        z /= kBlockDim;
        return x < mDim[0] && y < mDim[1] && z < mDim[2] ? mBlocks[blockIndex(x, y, z)] : kNoBlock;
    }
    /// Entries of the leaves that hold eight voxels. @param blocks offsets of the tables of the voxels' blocks
    [[nodiscard]] VDBLIC_INLINE Unsigned8 findLeaves(Int8 blocks, const Int8* voxel) const
    {
        const Int8 index = blocks + LeafBlock::leafIndex(voxel[0], voxel[1], voxel[2]);
        Unsigned8 entries;
        for (int lane = 0; lane < kLanes; ++lane)
            entries[lane] = mLeaves[unsigned(index[lane])];
        return entries;
    }
    /// Indices of the records of eight voxels, each in the leaf of an entry or next to it.
    [[nodiscard]] VDBLIC_INLINE static Unsigned8 findRecords(Unsigned8 entries, const Int8* voxel)
    {
        return (entries & ~kFlags) + kFirstVoxel +
               recordOffset(Unsigned8(voxel[0]), Unsigned8(voxel[1]), Unsigned8(voxel[2]));
    }
    /// Lanes whose entries have a flag are negative.
    [[nodiscard]] VDBLIC_INLINE static Int8 flagged(Unsigned8 entries, int bit) { return Int8(entries << (31 - bit)); }
    [[nodiscard]] const openvdb::Coord& origin() const { return mOrigin; }

  private:
    // An entry is a base plus flags in its low bits. The base is the record index, modulo 2³², at which the leaf's
    // padded records would begin if they reached voxel (0, 0, 0). Leaves begin at multiples of 8 voxels and have a
    // multiple of 8 records, so the low bits of every base are 0.
    static constexpr unsigned kFlags = 7, kNothing = 1 << kNothingBit, kPartly = 1 << kPartlyBit;
    static_assert(kPaddedSize % (kFlags + 1) == 0);
    static constexpr unsigned kFirstVoxel = paddedIndex(0, 0, 0);

    /// Distance of two records whose voxels lie this far apart, modulo 2³².
    template<typename Integer>
    VDBLIC_INLINE static Integer recordOffset(Integer x, Integer y, Integer z)
    {
        return (x * kPaddedDim + y) * kPaddedDim + z;
    }
    [[nodiscard]] std::size_t blockIndex(int x, int y, int z) const
    {
        return (std::size_t(x) * unsigned(mDim[1]) + unsigned(y)) * unsigned(mDim[2]) + unsigned(z);
    }

    openvdb::Coord mOrigin{0};
    int mDim[3] = {0, 0, 0};       // in blocks
    std::vector<int> mBlocks;      // offset of each block's table
    std::vector<unsigned> mLeaves; // all tables
};

} // namespace vdblic
