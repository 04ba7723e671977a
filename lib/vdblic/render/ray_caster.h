#pragma once

#include "vdblic/render/camera.h"
#include "vdblic/render/clipping.h"
#include "vdblic/render/image.h"
#include "vdblic/render/look.h"

#include <cstdint>
#include <vector>

namespace vdblic {

/// How rays are sampled.
struct RayCastParams {
    double step = 0.5; ///< between samples [voxels along the ray, in index space]
    /// A ray ends when less than this share of the light behind would come through. Samples that add less than this
    /// share to what their ray has so far are shaded together, as the last of them.
    double leastTransmittance = 1.0 / 256;
    ClipParams clip{};
    bool layers = false; ///< fill the image's layers too

    /// @throws ParameterError
    void validate() const;
};

/// Which leaves can contribute, found by place: what empty-space skipping needs. A block is a cube of 16³ leaves; only
/// blocks in which a leaf is visible have a table of them.
///
/// Places count from `first()`, below every leaf, so that they are never negative.
class VisibleLeaves {
  public:
    /// @param visible for each of the domain's leaves, not 0 if it contributes
    VisibleLeaves(const TextureVolume& volume, const std::vector<std::uint8_t>& visible);
    VisibleLeaves(const TextureVolume& volume, const Look& look);

    static constexpr int kBlockDim = 1 << LeafBlock::kLog2Voxels; ///< in voxels
    static constexpr int kNoBlock = 0; ///< the table of all blocks in which nothing is visible
    /// An entry of a table tells where the leaf's brick is, with flags in its lowest bits.
    static constexpr int kNothingBit = 0; ///< the leaf is not there or not visible
    static constexpr int kPartlyBit = 1;  ///< some of its voxels are not shown

    /// Where the table of the block around a voxel begins.
    [[nodiscard]] int findBlock(int x, int y, int z) const
    {
        x /= kBlockDim;
        y /= kBlockDim;
        z /= kBlockDim;
        return x < mDim[0] && y < mDim[1] && z < mDim[2] ? mBlocks[blockPlace(x, y, z)] : kNoBlock;
    }
    /// The entries of the leaves around eight voxels. @param blocks where the tables of their blocks begin
    [[nodiscard]] VDBLIC_INLINE Unsigned8 findLeaves(Int8 blocks, const Int8* voxel) const
    {
        const Int8 place = blocks + LeafBlock::leafIndex(voxel[0], voxel[1], voxel[2]);
        Unsigned8 entries;
        for (int lane = 0; lane < 8; ++lane)
            entries[lane] = mLeaves[unsigned(place[lane])];
        return entries;
    }
    /// The numbers of the records of voxels in or beside leaves. @param entries of the leaves
    [[nodiscard]] VDBLIC_INLINE static Unsigned8 findRecords(Unsigned8 entries, const Int8* voxel)
    {
        return (entries | kFlags) + recordSteps(Unsigned8(voxel[0]), Unsigned8(voxel[1]), Unsigned8(voxel[2]));
    }
    /// Lanes whose entries have a flag are negative.
    [[nodiscard]] VDBLIC_INLINE static Int8 flagged(Unsigned8 entries, int bit) { return Int8(entries << (31 - bit)); }
    [[nodiscard]] const openvdb::Coord& first() const { return mFirst; }

  private:
    static constexpr unsigned kFlags = 7, kNothing = 1 << kNothingBit, kPartly = 1 << kPartlyBit;

    /// How far records are from each other in a brick, modulo 2³².
    template<typename Integer>
    VDBLIC_INLINE static Integer recordSteps(Integer x, Integer y, Integer z)
    {
        return (x * kBrickDim + y) * kBrickDim + z;
    }
    /// The entry of a leaf: the number that the record of the place 0 0 0 would have if its brick went on to there,
    /// modulo 2³². Its lowest bits are always those of kFlags, so that flags can take their place.
    static unsigned entryOf(std::size_t leaf, const openvdb::Coord& origin);

    [[nodiscard]] std::size_t blockPlace(int x, int y, int z) const
    {
        return (std::size_t(x) * unsigned(mDim[1]) + unsigned(y)) * unsigned(mDim[2]) + unsigned(z);
    }

    openvdb::Coord mFirst{0};
    int mDim[3] = {0, 0, 0};       // in blocks
    std::vector<int> mBlocks;      // where their tables begin
    std::vector<unsigned> mLeaves; // all tables
};

/// The share of a step by which the steps of a pixel's ray are shifted along it, from a low-discrepancy sequence over
/// the picture (Roberts' R2), so that shells of samples leave no rings. Those of the pixel's further rays are spread
/// evenly between (van der Corput's sequence).
[[nodiscard]] float sampleShift(int x, int y, int ray = 0);

/// Cast a ray through each pixel's centre, front to back, with early termination.
///
/// What cuts and the active voxels' bounds leave of a ray is cut into steps at multiples of the step from the eye, plus
/// the pixel's shift: counted from there, no slope of a face can undo the shifts. A sample lies in the middle of its
/// step; the first and the last step are as long as is left. A sample whose voxel, which covers [i − ½, i + ½), is not
/// shown has no opacity. Optical depth counts voxels passed in index space, so a picture does not change with the unit
/// of length. What lies within a voxel of where its ray comes in is lit as the plane it came in through. Leaves left
/// out of `visible` are passed over. Same pixels for any number of threads.
/// @param ray which of a pixel's rays these are, for sampleShift()
[[nodiscard]] Image castRays(const TextureVolume& volume, const Look& look, const Camera& camera,
                             const RayCastParams& params, const VisibleLeaves& visible, int ray = 0);
/// The same, passing over what the look makes invisible; an empty volume gives an empty picture.
[[nodiscard]] Image castRays(const TextureVolume& volume, const Look& look, const Camera& camera,
                             const RayCastParams& params);

} // namespace vdblic
