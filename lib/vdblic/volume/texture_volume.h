#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/look/volume_values.h"
#include "vdblic/volume/placed_box.h"
#include "vdblic/volume/record_sampling.h"
#include "vdblic/volume/scalar_records.h"
#include "vdblic/volume/texture_records.h"

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace vdblic {

class LeafShare;
class TextureBlock;
struct Look;

/// What a volume's records are for; all there are unless that is known.
struct RecordUse {
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
/// Each leaf has records of the texture and of scalars (texture_records.h). Past the rim a texture goes on linearly for
/// two voxels, so that gradients there are those of inner voxels; scalars go on with their nearest neighbours'
/// mean. Of a sparse texture inactive voxels hold 0. Gradients are central differences of these values, taken where
/// they are asked for. Any number of threads may read; cut() and add…() must not run beside readers. Its box has the
/// bounds of the active voxels, faces included.
class TextureVolume : public PlacedBox {
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

    /// The texture. @pre the leaves of samples have records
    [[nodiscard]] TextureSampler texture() const { return {mRecords.get(), mScales.data()}; }
    /// The records of a leaf, by TextureLeaf, and what they mean.
    [[nodiscard]] const TextureRecord* records(std::size_t leaf) const
    {
        return mRecords.get() + leaf * TextureLeaf::kSize;
    }
    [[nodiscard]] const TextureScale& scale(std::size_t leaf) const { return mScales[leaf]; }
    /// Turns gradients in index space into those in world space [texture per mean voxel size], whose directions are
    /// normals.
    [[nodiscard]] const glm::mat3& gradientToWorld() const { return mGradientToWorld; }
    /// The scalar that opacity follows.
    [[nodiscard]] const ScalarRecords& drivers() const { return mDrivers; }
    /// By ScalarLeaf of all leaves; null unless addLines() was called.
    [[nodiscard]] const LineRecord* lines() const { return mLines.get(); }

    /// The voxels of a leaf that are shown: active, with finite values, not cut away.
    [[nodiscard]] const Mask& shown(std::size_t leaf) const { return mShown[leaf]; }
    /// Whether samples in some of a leaf's voxels are hidden. Those of a sparse texture are unless it was cut: inactive
    /// voxels are empty anyway.
    [[nodiscard]] bool isPartlyShown(std::size_t leaf) const { return (mIsCut || !mIsSparse) && !mShown[leaf].isOn(); }
    [[nodiscard]] const LeafRange& leafRange(std::size_t leaf) const { return mRanges[leaf]; }

    /// The scalar that colour follows; null unless addColors() was called.
    [[nodiscard]] const ScalarRecords* colors() const { return mColors ? &*mColors : nullptr; }

    /// The memory that a leaf's records take.
    [[nodiscard]] double bytesPerLeaf() const;
    /// @param scalarBytes of the scalars' values
    [[nodiscard]] static double bytesPerLeaf(bool hasLines, double scalarBytes);

    /// Show only voxels that lie in another domain of the same index space too.
    void cut(const Domain& kept);

    /// Compute lines(), for ShadingModel::kLine.
    void addLines();

    /// Let another scalar colour. Where it is not a finite number its neighbours decide.
    /// @throws InputError naming the grid if its transform differs from the texture's, but as the driver's may
    void addColors(const openvdb::FloatGrid& texture, const openvdb::FloatGrid& colors);

    /// Number of active voxels of own leaves that are left out because texture or driver is not a finite number.
    [[nodiscard]] std::size_t unusableVoxels() const { return mUnusable; }

    /// Values of shown voxels of own leaves that a hash of their coordinates chooses, a few hundred thousand; of a
    /// small domain all. So the parts of a domain have the same samples as the whole.
    [[nodiscard]] VolumeSamples samples() const;

  private:
    void copyLeaf(const openvdb::FloatGrid& texture, const openvdb::FloatGrid* scalar, const openvdb::Coord& origin,
                  TextureBlock& block) const;
    /// The number of the leaf that holds a voxel; −1 if there is none.
    [[nodiscard]] int findLeaf(const openvdb::Coord& voxel) const;

    std::shared_ptr<const Domain> mDomain;
    std::unique_ptr<TextureRecord[]> mRecords;
    std::vector<TextureScale> mScales;
    ScalarRecords mDrivers;
    std::unique_ptr<LineRecord[]> mLines;
    std::optional<ScalarRecords> mColors;
    std::vector<Mask> mShown;
    std::vector<LeafRange> mRanges;
    std::vector<std::uint8_t> mHasRecords; // by leaf; 0: hidden by RecordUse::look
    glm::mat3 mGradientToWorld{1};
    std::size_t mUnusable = 0;
    bool mIsSparse, mIsCut = false;
};

} // namespace vdblic
