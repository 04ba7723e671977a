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

/// Which leaves can contribute, found by place: what empty-space skipping needs.
///
/// Places count from `first()`, below every leaf, so that they are never negative.
class VisibleLeaves {
  public:
    /// @param visible for each of the domain's leaves, not 0 if it contributes
    VisibleLeaves(const TextureVolume& volume, const std::vector<std::uint8_t>& visible);
    VisibleLeaves(const TextureVolume& volume, const Look& look);

    static constexpr int kBlockShift = 7; ///< a block is 128 voxels wide
    static constexpr int kNoLeaf = -1;    ///< the leaf is not there or not visible
    static constexpr int kNoBlock = -2;   ///< nor is any in its block

    /// Twice the number of the leaf that covers a voxel, odd if some of its voxels are not shown; or kNoLeaf, kNoBlock.
    /// @param lanes those that are asked for; the others get kNoBlock
    [[nodiscard]] VDBLIC_INLINE Int8 find(const Int8* voxel, unsigned lanes) const
    {
        const Int8 x = voxel[0] >> kBlockShift, y = voxel[1] >> kBlockShift, z = voxel[2] >> kBlockShift;
        const Int8 inside = (x >= 0) & (x < mDim[0]) & (y >= 0) & (y < mDim[1]) & (z >= 0) & (z < mDim[2]);
        const Int8 block = ((x * mDim[1] + y) * mDim[2] + z + 1) & inside;
        const Int8 inBlock = ((voxel[0] >> 3) & 15) << 8 | ((voxel[1] >> 3) & 15) << 4 | ((voxel[2] >> 3) & 15);
        Int8 found = {kNoBlock, kNoBlock, kNoBlock, kNoBlock, kNoBlock, kNoBlock, kNoBlock, kNoBlock};
        for (; lanes != 0; lanes &= lanes - 1) {
            const int lane = __builtin_ctz(lanes), number = mBlocks[unsigned(block[lane])];
            if (number >= 0) found[lane] = mLeaves[std::size_t(number) * kBlockLeaves + unsigned(inBlock[lane])];
        }
        return found;
    }
    [[nodiscard]] const openvdb::Coord& first() const { return mFirst; }

  private:
    static constexpr std::size_t kBlockLeaves = 4096;

    openvdb::Coord mFirst{0};
    int mDim[3] = {0, 0, 0};
    std::vector<int> mBlocks; // number of the block at a place, after that of no place; −1 if it is empty
    std::vector<int> mLeaves;
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
