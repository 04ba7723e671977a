#pragma once

#include "vdblic/volume/voxel_box.h"

#include <openvdb/openvdb.h>

#include <cstdint>
#include <vector>

namespace vdblic {

class TextureVolume;
struct ClipParams;
struct Look;

/// A cube of voxels, some of them visible under a look.
struct ExtinctionCell {
    static constexpr int kLog2Dim = 2, kDim = 1 << kLog2Dim;
    static constexpr double kUnit = 1 / double(1 << 20); ///< sums of integers do not depend on their order

    std::uint64_t extinction; ///< sum over its voxels [kUnit]
    VoxelBox most;            ///< around the voxels with most of the extinction

    /// In cells.
    [[nodiscard]] openvdb::Coord place() const { return at(openvdb::Coord(most.low.data())); }
    [[nodiscard]] static openvdb::Coord at(const openvdb::Coord& voxel)
    {
        return {voxel[0] >> kLog2Dim, voxel[1] >> kLog2Dim, voxel[2] >> kLog2Dim};
    }
};

/// The cells of a rank's own leaves, in the order of the leaves. Hidden voxels and cells that are cut away do not
/// count.
/// @param clip in the volume's world space
[[nodiscard]] std::vector<ExtinctionCell> extinctionCells(const TextureVolume& volume, const Look& look,
                                                          const ClipParams& clip);

} // namespace vdblic
