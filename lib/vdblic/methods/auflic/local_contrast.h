#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"

#include <array>
#include <cstddef>
#include <vector>

namespace vdblic {

/// Mean and standard deviation of a texture around each voxel.
///
/// Moments are taken over blocks of 4³ voxels: wide enough to measure contrast, narrow enough to keep features from
/// growing broader than a few voxels. A voxel's moments are interpolated linearly between the centres of the nearest
/// blocks. Any number of threads may read after the last add().
class LocalContrast {
  public:
    /// @param domain must outlive this
    explicit LocalContrast(const Domain& domain);

    /// Add a leaf, once. @param values of the texture. Threads may add different leaves.
    void add(std::size_t leaf, const float* values) { sumBlocks(mDomain.mask(leaf), values, mMoments[leaf]); }

    /// Moments at a row's eight voxels along z; NaN where no nearby block has a voxel of the domain.
    struct Row {
        Float8 mean, deviation;
    };
    /// Returns the rows of one leaf. The leaf and those of its 26 neighbours that are in the domain must be added
    /// before.
    class Leaf {
      public:
        Leaf(const LocalContrast& contrast, const openvdb::Coord& origin);
        /// @param x, y of the row in the leaf, 0 to 7
        [[nodiscard]] VDBLIC_INLINE Row row(int x, int y) const
        {
            const Enclosing inX = enclosing(x), inY = enclosing(y);
            const auto mix = [](Float4 a, Float4 b, float t) { return a + (b - a) * t; };
            std::array<Float4, kAround> along; // moments of the blocks along z, at this x and y
            for (int k = 0; k < kAround; ++k) {
                const auto at = [&](int i, int j) {
                    const int block = ((inX.first + i) * kAround + inY.first + j) * kAround + k;
                    return mMoments[std::size_t(block)];
                };
                along[std::size_t(k)] =
                    mix(mix(at(0, 0), at(0, 1), inY.weight), mix(at(1, 0), at(1, 1), inY.weight), inX.weight);
            }
            Float4 moments[LeafVoxel::kDim];
            for (int z = 0; z < LeafVoxel::kDim; ++z) {
                const Enclosing inZ = enclosing(z);
                moments[z] = mix(along[std::size_t(inZ.first)], along[std::size_t(inZ.first) + 1], inZ.weight);
            }
            Float8 columns[4]; // count, sum, sum of squares
            transpose(moments, columns);
            const Float8 mean = columns[1] / columns[0], variance = columns[2] / columns[0] - mean * mean;
            return {mean, squareRoots(variance > 0 ? variance : Float8{})};
        }

      private:
        /// The two neighbouring blocks with centres around a voxel, along one axis.
        struct Enclosing {
            int first;    ///< counted from the block before the leaf
            float weight; ///< of the second block
        };
        VDBLIC_INLINE static constexpr Enclosing enclosing(int voxel)
        {
            const int first = (voxel + 2) / 4;
            return {first, (float(voxel) + 2.5f) / 4 - float(first)};
        }

        static constexpr int kAround = 4; // along each axis: the leaf's blocks, one before and one after
        static constexpr int kParts = kAround * kAround * kAround;
        std::array<Float4, kParts> mMoments;
    };

  private:
    static constexpr int kBlock = 4;                         // voxels of a block along each axis
    static constexpr int kBlocks = LeafVoxel::kDim / kBlock; // blocks of a leaf along each axis
    static int blockOf(LeafVoxel v) { return (v.x / kBlock * kBlocks + v.y / kBlock) * kBlocks + v.z / kBlock; }

    static constexpr int kBlockCount = kBlocks * kBlocks * kBlocks;
    /// For each block of a leaf: count, sum and sum of squares of its values.
    using Moments = std::array<Float4, kBlockCount>;
    static void sumBlocks(const Domain::Mask& mask, const float* values, Moments& moments);

    const Domain& mDomain;
    std::vector<Moments> mMoments;
};

} // namespace vdblic
