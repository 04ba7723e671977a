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
    /// A ray ends when less than this share of the light behind would come through.
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
    [[nodiscard]] VDBLIC_INLINE int find(Int4 voxel) const
    {
        const unsigned x = unsigned(voxel[0] >> kBlockShift), y = unsigned(voxel[1] >> kBlockShift),
                       z = unsigned(voxel[2] >> kBlockShift);
        if (x >= mDim[0] || y >= mDim[1] || z >= mDim[2]) return kNoBlock;
        const int block = mBlocks[(std::size_t(x) * mDim[1] + y) * mDim[2] + z];
        if (block < 0) return kNoBlock;
        const int inBlock = ((voxel[0] >> 3) & 15) << 8 | ((voxel[1] >> 3) & 15) << 4 | ((voxel[2] >> 3) & 15);
        return mLeaves[std::size_t(block) * kBlockLeaves + std::size_t(inBlock)];
    }
    [[nodiscard]] const openvdb::Coord& first() const { return mFirst; }

  private:
    static constexpr std::size_t kBlockLeaves = 4096;

    openvdb::Coord mFirst{0};
    unsigned mDim[3] = {0, 0, 0};
    std::vector<int> mBlocks; // number of the block at a place, or −1
    std::vector<int> mLeaves;
};

/// The share of a step by which a pixel's samples are shifted, from a low-discrepancy sequence over the picture
/// (Roberts' R2), so that planes of samples leave no rings.
[[nodiscard]] float sampleShift(int x, int y);

/// Cast a ray through each pixel's centre, front to back, with early termination.
///
/// A ray counts from where it enters what the cuts leave of the active voxels' bounds. Its samples lie at (n +
/// shift)·step from there and stand for the way half-way to the next one, the first and the last to the ends of the
/// ray, and lie in the middle of that. One whose voxel, which covers [i − ½, i + ½), is not shown has no opacity.
/// Optical depth counts voxels passed in index space, so a picture does not change with the unit of length. What lies
/// within a voxel of where its ray comes in is lit as the plane it came in through. Leaves left out of `visible` are
/// passed over. Same pixels for any number of threads.
[[nodiscard]] Image castRays(const TextureVolume& volume, const Look& look, const Camera& camera,
                             const RayCastParams& params, const VisibleLeaves& visible);
/// The same, passing over what the look makes invisible; an empty volume gives an empty picture.
[[nodiscard]] Image castRays(const TextureVolume& volume, const Look& look, const Camera& camera,
                             const RayCastParams& params);

} // namespace vdblic
