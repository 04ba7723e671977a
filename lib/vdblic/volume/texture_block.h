#pragma once

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/volume/texture_records.h"
#include "vdblic/volume/texture_volume.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>

namespace vdblic {

/// A leaf and the voxels around it, copied from the trees: the source of its records.
///
/// Large: keep one a thread.
class TextureBlock {
  public:
    /// Active voxels whose values are not finite count as inactive.
    /// @param driver null: the texture's voxels alone count
    void copy(const openvdb::FloatTree& texture, const openvdb::FloatTree* driver, const openvdb::Coord& origin);
    /// The same of a sparse texture: inactive voxels are empty, their texture is 0.
    void copySparse(const openvdb::FloatTree& texture, const openvdb::FloatTree* driver, const openvdb::Coord& origin);

    /// Let the values go on past the rim, twice: an inactive voxel follows its nearest neighbours that have a value,
    /// those that share a face, else an edge, else a corner. A driver is the mean of theirs. A texture goes on along
    /// the line through each of them and the voxel behind it, so that the rim is lit as what it bounds. Of a sparse
    /// texture only drivers go on, once.
    void extend();

    /// Of samples in the leaf, by the active voxels in ScalarLeaf.
    [[nodiscard]] LeafRange range() const;
    /// @return the scale of the records
    [[nodiscard]] TextureScale writeTexture(TextureRecord* records) const;
    /// @param values receives ScalarLeaf
    void writeDrivers(float* values) const;
    /// Remove inactive voxels from the leaf's mask. @return number of voxels removed
    std::size_t removeInactive(TextureVolume::Mask& mask) const;

    static constexpr int kRim = 4, kDim = LeafVoxel::kDim + 2 * kRim;
    /// Index of a voxel. @param x, y, z from −kRim to 7 + kRim, relative to the leaf's origin
    static constexpr int index(int x, int y, int z) { return ((x + kRim) * kDim + y + kRim) * kDim + z + kRim; }
    /// A bit for each voxel of a row along z, the first one the lowest.
    using RowBits = std::uint16_t;
    static constexpr int row(int x, int y) { return (x + kRim) * kDim + y + kRim; }

  private:
    static constexpr int kSize = kDim * kDim * kDim, kRows = kDim * kDim;

    void copyRim(const openvdb::FloatTree& texture, const openvdb::FloatTree* driver, const openvdb::Coord& origin,
                 int rim);
    void removeNotFinite(int rim);
    void clearInactive();
    void extendBy(int rim);
    void extend(int voxel, int row, int z);

    float mTexture[kSize], mDriver[kSize];
    RowBits mActive[kRows], mKnown[kRows]; // voxels that are active; those that have a value
    bool mWhole;                           // every voxel that records depend on is active
    bool mIsSparse, mHasDriver;
};

} // namespace vdblic
