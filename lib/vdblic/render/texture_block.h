#pragma once

#include "vdblic/render/texture_records.h"
#include "vdblic/render/texture_volume.h"

#include <glm/mat3x3.hpp>

namespace vdblic {

/// A leaf and two voxels around it, copied out of the trees: all that its bricks are made from.
///
/// Large; one a thread.
class TextureBlock {
  public:
    /// Active voxels whose values are not finite count as inactive.
    void copy(const openvdb::FloatTree& texture, const openvdb::FloatTree& magnitude, const openvdb::Coord& origin);

    /// Give inactive voxels the mean of their nearest active neighbours, of those that share a face, else an edge, else
    /// a corner.
    void extend();

    [[nodiscard]] LeafRange range() const;
    void writeValues(ValueRecord* brick) const;
    /// @param gradientToWorld from texture per voxel in index space
    void writeGradients(const glm::mat3& gradientToWorld, GradientRecord* brick) const;
    /// Take inactive voxels of the leaf itself out of its mask. @return how many of the mask's were
    std::size_t removeInactive(TextureVolume::Mask& mask) const;

    static constexpr int kDim = LeafVoxel::kDim + 4;
    /// Where a voxel is. @param x from −2 to 9, counted from the leaf's origin; so are y and z
    static constexpr int index(int x, int y, int z) { return ((x + 2) * kDim + y + 2) * kDim + z + 2; }

  private:
    static constexpr int kSize = kDim * kDim * kDim;

    void extend(int voxel);

    float mTexture[kSize], mMagnitude[kSize];
    int mActive[kSize]; // 1 or 0; as wide as the values, for they are looked at together
    bool mWhole;        // all of it is active
};

} // namespace vdblic
