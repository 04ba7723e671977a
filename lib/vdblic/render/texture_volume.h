#pragma once

#include "vdblic/render/camera.h"
#include "vdblic/render/texture_records.h"

#include <openvdb/openvdb.h>

#include <memory>
#include <vector>

namespace vdblic {

/// The values of a leaf's active voxels and of those one voxel around it: all that its samples can meet.
struct LeafRange {
    float lowMagnitude, highMagnitude, highTexture;
};

/// A texture and a magnitude made ready for ray casting.
///
/// For each leaf a brick of values and one of gradients (texture_records.h). Inactive voxels beside active ones hold
/// the mean of their nearest active neighbours, so that values go on past the rim as they are in its last voxels. The
/// gradient is taken between active neighbours, one-sided at the rim, and turned into world space, in texture
/// per mean voxel size, so that its direction is the normal; where a voxel is inactive it is 0. Immutable once the
/// cuts are made; any number of threads may read.
class TextureVolume {
  public:
    using Mask = Domain::Mask;

    /// @param magnitude may be the texture itself
    /// @param stretch   factors on the grids' world space, along its axes: the volume's own is that much longer
    /// @throws InputError naming the grid if a transform is not affine, or the two transforms differ
    TextureVolume(const openvdb::FloatGrid& texture, const openvdb::FloatGrid& magnitude,
                  const glm::dvec3& stretch = glm::dvec3(1));

    [[nodiscard]] const Domain& domain() const { return *mDomain; }
    [[nodiscard]] bool empty() const { return domain().leafCount() == 0; }

    /// Records of all leaves, kBrickSize each.
    [[nodiscard]] const ValueRecord* values() const { return mValues.get(); }
    [[nodiscard]] const GradientRecord* gradients() const { return mGradients.get(); }
    /// Null unless addLines() was called.
    [[nodiscard]] const LineRecord* lines() const { return mLines.get(); }

    /// The voxels of a leaf that can be seen: active, with finite values, not cut away.
    [[nodiscard]] const Mask& shown(std::size_t leaf) const { return mShown[leaf]; }
    [[nodiscard]] const LeafRange& leafRange(std::size_t leaf) const { return mRanges[leaf]; }

    /// Show only voxels that are in another domain, too, of the same index space.
    void cut(const Domain& kept);

    /// Find the direction of the lines at each voxel, for shading them as lines.
    void addLines();

    /// The active voxels' bounds in index space: from the first ones' lower to the last ones' upper faces.
    [[nodiscard]] const glm::dvec3& low() const { return mLow; }
    [[nodiscard]] const glm::dvec3& high() const { return mHigh; }
    /// The same box's corners in world space.
    [[nodiscard]] Corners corners() const;

    [[nodiscard]] const glm::dmat4& indexToWorld() const { return mIndexToWorld; }
    [[nodiscard]] const glm::dmat4& worldToIndex() const { return mWorldToIndex; }

    /// Active voxels whose texture or magnitude is not a finite number; they are left out.
    [[nodiscard]] std::size_t unusableVoxels() const { return mUnusable; }

    /// The values of evenly chosen voxels that are shown, a few hundred thousand at most.
    struct Samples {
        std::vector<float> texture, magnitude;
    };
    [[nodiscard]] Samples samples() const;

  private:
    std::shared_ptr<const Domain> mDomain;
    std::unique_ptr<ValueRecord[]> mValues;
    std::unique_ptr<GradientRecord[]> mGradients;
    std::unique_ptr<LineRecord[]> mLines;
    std::vector<Mask> mShown;
    std::vector<LeafRange> mRanges;
    glm::dvec3 mLow{0}, mHigh{0};
    glm::dmat4 mIndexToWorld{1}, mWorldToIndex{1};
    std::size_t mUnusable = 0;
};

} // namespace vdblic
