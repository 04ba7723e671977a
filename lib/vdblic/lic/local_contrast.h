#pragma once

#include "vdblic/field/domain.h"

#include <array>
#include <vector>

namespace vdblic {

/// Mean and standard deviation of a texture around each voxel.
///
/// Taken over blocks of 4³ voxels: wide enough to tell contrast, narrow enough that no feature grows broader than a few
/// voxels. Around a voxel the moments of the nearest blocks are weighted linearly by the distance of their centres.
class LocalContrast {
  public:
    /// Takes the moments of every block, in parallel; the result does not depend on the number of threads.
    LocalContrast(const Domain& domain, const LeafValues<float>& values);

    /// Of the eight voxels of a row along z. Not-a-number far from every voxel of the domain.
    struct Row {
        Float8 mean, deviation;
    };
    /// Gives the rows of one leaf.
    class Leaf {
      public:
        Leaf(const LocalContrast& contrast, const openvdb::Coord& origin);
        /// @param x, y of the row in the leaf, 0 to 7
        [[nodiscard]] Row row(int x, int y) const;

      private:
        static constexpr int kAround = 4; // the leaf's blocks and one before and after, along each axis
        std::array<Float4, kAround * kAround * kAround> mMoments;
    };

  private:
    static constexpr int kBlock = 4, kBlocks = 2; // voxels of a block, blocks of a leaf; along each axis
    static int blockOf(LeafVoxel v) { return (v.x / kBlock * kBlocks + v.y / kBlock) * kBlocks + v.z / kBlock; }

    /// Of each block of a leaf: number, sum and sum of squares of its values.
    using Moments = std::array<Float4, kBlocks * kBlocks * kBlocks>;

    const Domain& mDomain;
    std::vector<Moments> mMoments;
};

} // namespace vdblic
