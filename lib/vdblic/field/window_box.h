#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/field/vector.h"

namespace vdblic {

/// A box of voxels that the domain has, in a leaf and the 26 around it: what needs no look at the masks.
///
/// If the window's voxels of the domain are exactly a box, it is that one. Else it is the leaf in the middle, grown by
/// full leaves as far as it remains a box, and empty if that leaf is not full. Immutable; any number of threads may
/// read.
class WindowBox {
  public:
    WindowBox(const Domain& domain, const LeafWindow& window);

    /// Whether the domain has no voxel of the window outside the box.
    [[nodiscard]] bool isExact() const { return mIsExact; }
    /// Whether the domain has every voxel of the window.
    [[nodiscard]] bool isWindow() const { return mIsWindow; }

    /// Which of eight cells, each with its corner before the other ones, have all corners in the box.
    [[nodiscard]] VDBLIC_INLINE Int8 holdsCell(Int8 x, Int8 y, Int8 z) const
    {
        return (x >= mFirst[0]) & (x < mLast[0]) & (y >= mFirst[1]) & (y < mLast[1]) & (z >= mFirst[2]) &
               (z < mLast[2]);
    }
    /// Which of eight coordinates are the box's. @param axis 0 to 2
    [[nodiscard]] VDBLIC_INLINE Int8 holds(int axis, Int8 coordinate) const
    {
        return (coordinate >= mFirst[axis]) & (coordinate <= mLast[axis]);
    }

  private:
    [[nodiscard]] bool coverWindow(const Domain& domain, const LeafWindow& window);
    void growFromMiddle(const Domain& domain, const LeafWindow& window);
    void set(const LeafWindow& window, int axis, int firstLeaf, int lastLeaf);

    int mFirst[3] = {0, 0, 0}, mLast[3] = {-1, -1, -1}; // voxels, in index space
    bool mIsExact = false, mIsWindow = false;
};

} // namespace vdblic
