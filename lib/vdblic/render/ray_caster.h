#pragma once

#include "vdblic/render/camera.h"
#include "vdblic/render/image.h"
#include "vdblic/render/look.h"

#include <cstdint>
#include <vector>

namespace vdblic {

/// How rays are sampled.
struct RayCastParams {
    double step = 0.5; ///< between samples [voxels along the ray, in index space]
    /// A ray ends when less than this share of the light behind would come through.
    double leastTransmittance = 1.0 / 512;
    bool layers = false; ///< fill the image's layers too

    /// @throws ParameterError
    void validate() const;
};

/// Which leaves can contribute, and which blocks of 16³ leaves hold one that does: what empty-space skipping needs.
class VisibleLeaves {
  public:
    /// @param visible for each of the domain's leaves, not 0 if it contributes
    VisibleLeaves(const Domain& domain, std::vector<std::uint8_t> visible);
    VisibleLeaves(const TextureVolume& volume, const Look& look);

    [[nodiscard]] VDBLIC_INLINE bool leaf(int leaf) const { return mLeaves[std::size_t(leaf)] != 0; }
    [[nodiscard]] VDBLIC_INLINE bool block(Int4 voxel) const
    {
        const unsigned x = unsigned((voxel[0] >> kBlockShift) - mFirst[0]);
        const unsigned y = unsigned((voxel[1] >> kBlockShift) - mFirst[1]);
        const unsigned z = unsigned((voxel[2] >> kBlockShift) - mFirst[2]);
        return x < mDim[0] && y < mDim[1] && z < mDim[2] && mBlocks[(std::size_t(x) * mDim[1] + y) * mDim[2] + z] != 0;
    }
    static constexpr int kBlockShift = 7; ///< a block is 128 voxels wide

  private:
    std::vector<std::uint8_t> mLeaves, mBlocks;
    openvdb::Coord mFirst;
    unsigned mDim[3] = {0, 0, 0};
};

/// The share of a step by which a pixel's samples are shifted, from a low-discrepancy sequence over the picture
/// (Roberts' R2), so that planes of samples leave no rings.
[[nodiscard]] float sampleShift(int x, int y);

/// Cast a ray through each pixel's centre, front to back, with early termination.
///
/// The samples of a ray lie at (n + shift)·step from where it enters the active voxels' bounds. One whose voxel,
/// which covers [i − ½, i + ½), is not active has no opacity. Optical depth counts voxels passed in index space, so a
/// picture does not change with the unit of length. Leaves left out of `visible` are passed over.
/// Same pixels for any number of threads.
[[nodiscard]] Image castRays(const TextureVolume& volume, const Look& look, const Camera& camera,
                             const RayCastParams& params, const VisibleLeaves& visible);
/// The same, passing over what the look makes invisible; an empty volume gives an empty picture.
[[nodiscard]] Image castRays(const TextureVolume& volume, const Look& look, const Camera& camera,
                             const RayCastParams& params);

} // namespace vdblic
