#pragma once

#include "vdblic/field/inlined.h"

namespace vdblic {

/// Coordinates and offset of a voxel in its leaf, OpenVDB's block of 8³ voxels.
///
/// A voxel's offset is its index among the leaf's values, x slowest. Offsets of the eight voxels along z that make a
/// row follow each other. Functions of an `Integer` take index coordinates anywhere in index space, negative ones too,
/// as one integer or as a vector of one a lane.
struct LeafVoxel {
    static constexpr int kLog2Dim = 3;
    static constexpr int kDim = 1 << kLog2Dim;
    static constexpr int kRows = kDim * kDim;   ///< of a leaf
    static constexpr int kCount = kRows * kDim; ///< voxels of a leaf

    int x, y, z; ///< 0 to kDim − 1

    /// The voxel at an offset.
    [[nodiscard]] VDBLIC_INLINE static constexpr LeafVoxel at(unsigned offset)
    {
        return {int(offset >> 2 * kLog2Dim), int(local(offset >> kLog2Dim)), int(local(offset))};
    }
    /// The first voxel of a row.
    [[nodiscard]] VDBLIC_INLINE static constexpr LeafVoxel ofRow(int row) { return {row >> kLog2Dim, local(row), 0}; }

    /// The leaf along one axis that an index coordinate lies in, counted in leaves.
    template<typename Integer>
    [[nodiscard]] VDBLIC_INLINE static constexpr Integer leafCoordinate(Integer coordinate)
    {
        return coordinate >> kLog2Dim;
    }
    /// The part of an index coordinate within its leaf, 0 to kDim − 1.
    template<typename Integer>
    [[nodiscard]] VDBLIC_INLINE static constexpr Integer local(Integer coordinate)
    {
        return coordinate & (kDim - 1);
    }
    /// The row in its leaf of the voxels with these index coordinates.
    template<typename Integer>
    [[nodiscard]] VDBLIC_INLINE static constexpr Integer row(Integer x, Integer y)
    {
        return local(x) << kLog2Dim | local(y);
    }
    /// The offset in its leaf of the voxel with these index coordinates.
    template<typename Integer>
    [[nodiscard]] VDBLIC_INLINE static constexpr Integer offset(Integer x, Integer y, Integer z)
    {
        return local(x) << 2 * kLog2Dim | local(y) << kLog2Dim | local(z);
    }
};

/// A cube of 16³ leaves, as OpenVDB's lower internal nodes.
struct LeafBlock {
    static constexpr int kLog2Dim = 4; ///< in leaves
    static constexpr int kLog2Voxels = kLog2Dim + LeafVoxel::kLog2Dim;
    static constexpr int kCount = 1 << 3 * kLog2Dim; ///< leaves of a block

    /// The index in its block, x slowest, of the leaf around the voxel with these index coordinates.
    template<typename Integer>
    [[nodiscard]] VDBLIC_INLINE static constexpr Integer leafIndex(Integer x, Integer y, Integer z)
    {
        constexpr int kMask = (1 << kLog2Dim) - 1, kShift = LeafVoxel::kLog2Dim;
        return (x << (2 * kLog2Dim - kShift) & kMask << 2 * kLog2Dim) | (y << (kLog2Dim - kShift) & kMask << kLog2Dim) |
               (z >> kShift & kMask);
    }
};

} // namespace vdblic
