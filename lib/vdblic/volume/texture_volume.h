#pragma once

#include "vdblic/camera/camera.h"
#include "vdblic/field/domain.h"
#include "vdblic/look/volume_values.h"
#include "vdblic/volume/texture_records.h"

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace vdblic {

class LeafShare;
struct Look;

/// What a volume's records are for; all there are unless that is known.
struct RecordUse {
    bool gradients = true;      ///< whether gradients are read
    const Look* look = nullptr; ///< the only look that the volume is shown in: leaves that it hides get no records
    const LeafShare* share = nullptr; ///< the leaves that this rank has; null: all
    int rim = 0;                      ///< voxels around those leaves that are read, too
    bool isSparse = false;            ///< whether inactive voxels are empty, and not without a value
};

/// A texture and the scalars that drive its colour and opacity (TransferParams), prepared for ray casting.
///
/// Of several ranks that share a picture each has a part of the leaves, its own ones and those it needs; numbers of
/// leaves are among these. Domain and bounds are the whole volume's.
///
/// Each leaf has padded records of values and of gradients (texture_records.h). Inactive voxels next to active ones
/// hold the mean of their nearest active neighbours, which continues the values past the rim. Gradients are central
/// differences, one-sided at the rim, 0 in inactive voxels, in world space [texture per mean voxel size]: their
/// directions are normals. Of a sparse texture inactive voxels hold 0, and gradients are central everywhere. Any number
/// of threads may read; cut() and add…() must not run beside readers.
class TextureVolume {
  public:
    using Mask = Domain::Mask;

    /// @param driver the scalar that opacity and, unless there is addColors(), colour follow; may be the texture itself
    /// @param stretch factors along the axes from the grids' world space to the volume's
    /// @param use     what it leaves out must not be read; samples() and addLines() need the records of all leaves
    /// @throws InputError naming the grid if a transform is not affine, or the two transforms differ; that of a sparse
    ///         texture may refine the driver's
    TextureVolume(const openvdb::FloatGrid& texture, const openvdb::FloatGrid& driver,
                  const glm::dvec3& stretch = glm::dvec3(1), const RecordUse& use = {});

    [[nodiscard]] const Domain& domain() const { return *mDomain; }
    [[nodiscard]] bool empty() const { return domain().leafCount() == 0; }

    /// The leaves that this rank has: all of the domain's, by their numbers there, unless ranks share the volume.
    [[nodiscard]] std::size_t leafCount() const { return domain().local().size(); }
    [[nodiscard]] openvdb::Coord origin(std::size_t leaf) const { return domain().origin(domain().local()[leaf]); }
    /// Whether this is the rank that counts a leaf.
    [[nodiscard]] bool isOwn(std::size_t leaf) const { return domain().isOwn(domain().local()[leaf]); }

    /// Records of all leaves, kPaddedSize for each, by paddedIndex().
    [[nodiscard]] const ValueRecord* values() const { return mValues.get(); }
    /// Null if RecordUse has none.
    [[nodiscard]] const GradientRecord* gradients() const { return mGradients.get(); }
    /// Null unless addLines() was called.
    [[nodiscard]] const LineRecord* lines() const { return mLines.get(); }

    /// The voxels of a leaf that are shown: active, with finite values, not cut away.
    [[nodiscard]] const Mask& shown(std::size_t leaf) const { return mShown[leaf]; }
    [[nodiscard]] const LeafRange& leafRange(std::size_t leaf) const { return mRanges[leaf]; }

    /// The scalar that colour follows, by records as values(); null unless addColors() was called.
    [[nodiscard]] const float* colors() const { return mColors.get(); }

    /// Show only voxels that lie in another domain of the same index space too.
    void cut(const Domain& kept);

    /// Compute lines(), for ShadingModel::kLine.
    void addLines();

    /// Let another scalar colour. Where it is not a finite number its neighbours decide.
    /// @throws InputError naming the grid if its transform differs from the texture's, but as the driver's may
    void addColors(const openvdb::FloatGrid& texture, const openvdb::FloatGrid& colors);

    /// Bounds of the active voxels, faces included, in index space.
    [[nodiscard]] const glm::dvec3& low() const { return mLow; }
    [[nodiscard]] const glm::dvec3& high() const { return mHigh; }
    /// The corners of that box in world space.
    [[nodiscard]] Corners corners() const;

    [[nodiscard]] const glm::dmat4& indexToWorld() const { return mIndexToWorld; }
    [[nodiscard]] const glm::dmat4& worldToIndex() const { return mWorldToIndex; }

    /// Number of active voxels of own leaves that are left out because texture or driver is not a finite number.
    [[nodiscard]] std::size_t unusableVoxels() const { return mUnusable; }

    /// Values of shown voxels of own leaves that a hash of their coordinates chooses, a few hundred thousand; of a
    /// small domain all. So the samples of a domain's parts are those of the whole.
    [[nodiscard]] VolumeSamples samples() const;

  private:
    /// The number of the leaf that holds a voxel; −1 if there is none.
    [[nodiscard]] int findLeaf(const openvdb::Coord& voxel) const;

    std::shared_ptr<const Domain> mDomain;
    std::unique_ptr<ValueRecord[]> mValues;
    std::unique_ptr<GradientRecord[]> mGradients;
    std::unique_ptr<LineRecord[]> mLines;
    std::unique_ptr<float[]> mColors;
    std::vector<Mask> mShown;
    std::vector<LeafRange> mRanges;
    std::vector<std::uint8_t> mHasRecords; // by leaf; 0: hidden by RecordUse::look
    glm::dvec3 mLow{0}, mHigh{0};
    glm::dmat4 mIndexToWorld{1}, mWorldToIndex{1};
    std::size_t mUnusable = 0;
    bool mIsSparse;
};

} // namespace vdblic
