#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"

#include <openvdb/openvdb.h>

#include <array>
#include <cstddef>

namespace vdblic {

/// A leaf and its 26 neighbours: finds the leaves of eight voxels at once.
///
/// The leaves fill slots 0 to 26, x slowest; kCentre is the leaf itself, kElsewhere stands for all outside the window.
struct LeafWindow {
    static constexpr int kDim = 3, kCentre = 13, kElsewhere = kDim * kDim * kDim;

    int first[3] = {1 << 20, 1 << 20, 1 << 20}; ///< of the window, in leaves; by default everything is elsewhere
    std::array<int, kElsewhere + 1> leaves;     ///< number of the leaf in each slot; −1 where there is none

    LeafWindow() { leaves.fill(-1); }
    LeafWindow(const Domain& domain, const openvdb::Coord& origin)
    {
        for (int axis = 0; axis < 3; ++axis)
            first[axis] = LeafVoxel::leafCoordinate(origin[axis]) - 1;
        for (int slot = 0; slot < kElsewhere; ++slot) {
            const Int4 voxel = {(first[0] + slot / (kDim * kDim)) * LeafVoxel::kDim,
                                (first[1] + slot / kDim % kDim) * LeafVoxel::kDim,
                                (first[2] + slot % kDim) * LeafVoxel::kDim, 0};
            leaves[std::size_t(slot)] = domain.findLeaf(voxel);
        }
        leaves[kElsewhere] = -1;
    }

    /// The slot of a leaf, counted along each axis from the window's first.
    [[nodiscard]] VDBLIC_INLINE static constexpr int slot(int x, int y, int z) { return (x * kDim + y) * kDim + z; }

    /// The slots of eight voxels.
    [[nodiscard]] VDBLIC_INLINE Int8 slots(Int8 x, Int8 y, Int8 z) const
    {
        const Int8 i = LeafVoxel::leafCoordinate(x) - first[0], j = LeafVoxel::leafCoordinate(y) - first[1],
                   k = LeafVoxel::leafCoordinate(z) - first[2];
        const auto a = Unsigned8(i), b = Unsigned8(j), c = Unsigned8(k); // far voxels may wrap around
        constexpr unsigned kLast = kDim - 1;
        const Int8 elsewhere = Int8((a > kLast) | (b > kLast) | (c > kLast));
        const auto inside = Int8((a << 3) + a + (b << 1) + b + c); // slot(i, j, k) without multiplications
        return elsewhere ? Int8{} + kElsewhere : inside;
    }
};

/// A voxel found through a LeafWindow, as one code: its leaf's slot and its offset in the leaf. A negative code is the
/// index of a voxel outside the window in a separate list.
struct WindowVoxel {
    int code;

    /// The codes of eight voxels in the window. @param slots of the voxels
    [[nodiscard]] VDBLIC_INLINE static Int8 encode(Int8 slots, Int8 x, Int8 y, Int8 z)
    {
        return slots << kOffsetBits | LeafVoxel::offset(x, y, z);
    }
    /// The code of a voxel elsewhere.
    [[nodiscard]] VDBLIC_INLINE static constexpr int encodeFar(std::size_t index) { return -1 - int(index); }

    [[nodiscard]] VDBLIC_INLINE constexpr bool isFar() const { return code < 0; }
    [[nodiscard]] VDBLIC_INLINE constexpr std::size_t farIndex() const { return std::size_t(-1 - code); }
    [[nodiscard]] VDBLIC_INLINE constexpr int slot() const
    {
        return int(unsigned(code) >> kOffsetBits); // of a voxel in the window
    }
    [[nodiscard]] VDBLIC_INLINE constexpr unsigned offset() const { return unsigned(code & kOffsetMask); }

  private:
    static constexpr int kOffsetBits = 3 * LeafVoxel::kLog2Dim, kOffsetMask = LeafVoxel::kCount - 1;
};

} // namespace vdblic
