#pragma once

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/volume/texture_records.h"
#include "vdblic/volume/texture_volume.h"

#include <glm/mat3x3.hpp>
#include <openvdb/openvdb.h>

#include <cstddef>

namespace vdblic {

class CoarseScalar;

/// A leaf and two voxels around it, copied from the trees: all that its padded leaf is made from.
///
/// Large: keep one a thread.
class TextureBlock {
  public:
    /// Active voxels whose values are not finite count as inactive.
    void copy(const openvdb::FloatTree& texture, const openvdb::FloatTree& driver, const openvdb::Coord& origin);
    /// The same with a driver on coarser voxels. All voxels have its values then, inactive ones too.
    void copy(const openvdb::FloatTree& texture, const CoarseScalar& driver, const openvdb::Coord& origin);

    /// From now on inactive voxels are empty: their texture is 0, and has a gradient.
    void setEmpty();

    /// Set inactive voxels to the mean of their nearest active neighbours: of those that share a face, else an edge,
    /// else a corner.
    void extend();

    [[nodiscard]] LeafRange range() const;
    void writeValues(ValueRecord* records) const;
    void writeDrivers(float* drivers) const;
    /// @param gradientToWorld from texture per voxel in index space
    void writeGradients(const glm::mat3& gradientToWorld, GradientRecord* records) const;
    /// Remove inactive voxels from the leaf's mask. @return number of voxels removed
    std::size_t removeInactive(TextureVolume::Mask& mask) const;

    static constexpr int kDim = LeafVoxel::kDim + 4;
    /// Index of a voxel. @param x, y, z from −2 to 9, relative to the leaf's origin
    static constexpr int index(int x, int y, int z) { return ((x + 2) * kDim + y + 2) * kDim + z + 2; }

  private:
    static constexpr int kSize = kDim * kDim * kDim;

    void extend(int voxel);
    void copied();

    float mTexture[kSize], mDriver[kSize];
    int mActive[kSize]; // 1 or 0; as wide as the values, so that loops over both vectorize
    bool mWhole;        // every voxel is active
    bool mIsEmpty;      // inactive voxels are empty
    bool mHasDrivers;   // of inactive voxels too
};

} // namespace vdblic
