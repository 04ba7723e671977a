#pragma once

#include "vdblic/field/bricks.h"
#include "vdblic/render/camera.h"

#include <openvdb/openvdb.h>

namespace vdblic {

/// The values of a leaf's active voxels and of those one voxel around it: all that its samples can meet.
struct LeafRange {
    float lowMagnitude, highMagnitude, highTexture;
};

/// A texture and a magnitude made ready for ray casting.
///
/// A voxel's record holds texture, magnitude, coverage and the gradient of the texture, premultiplied by coverage.
/// The gradient is taken between active neighbours, one-sided at the rim, and turned into world space, in texture
/// per mean voxel size, so that its direction is the normal. Immutable; any number of threads may read.
class TextureVolume {
  public:
    enum Lane { kTexture, kMagnitude, kCoverage, kGradientX, kGradientY, kGradientZ };

    /// @param magnitude may be the texture itself
    /// @throws InputError naming the grid if a transform is not affine, or the two transforms differ
    TextureVolume(const openvdb::FloatGrid& texture, const openvdb::FloatGrid& magnitude);

    [[nodiscard]] const Bricks& bricks() const { return mBricks; }
    [[nodiscard]] const Domain& domain() const { return mBricks.domain(); }
    [[nodiscard]] const LeafRange& leafRange(std::size_t leaf) const { return mRanges[leaf]; }
    [[nodiscard]] bool empty() const { return domain().leafCount() == 0; }

    /// The active voxels' bounds in index space: from the first ones' lower to the last ones' upper faces.
    [[nodiscard]] const glm::dvec3& low() const { return mLow; }
    [[nodiscard]] const glm::dvec3& high() const { return mHigh; }
    /// The same box's corners in world space.
    [[nodiscard]] Corners corners() const;

    [[nodiscard]] const glm::dmat4& indexToWorld() const { return mIndexToWorld; }
    [[nodiscard]] const glm::dmat4& worldToIndex() const { return mWorldToIndex; }

    /// Active voxels whose texture or magnitude is not a finite number; they are left out.
    [[nodiscard]] std::size_t unusableVoxels() const { return mUnusable; }

    /// The values of evenly chosen active voxels, a few hundred thousand at most.
    struct Samples {
        std::vector<float> texture, magnitude;
    };
    [[nodiscard]] Samples samples() const;

  private:
    Bricks mBricks;
    std::vector<LeafRange> mRanges;
    glm::dvec3 mLow{0}, mHigh{0};
    glm::dmat4 mIndexToWorld{1}, mWorldToIndex{1};
    std::size_t mUnusable = 0;
};

} // namespace vdblic
