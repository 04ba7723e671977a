#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/field/vector.h"

namespace vdblic {

/// A box of domain voxels in a leaf and its 26 neighbours, where no mask needs to be read.
///
/// If the window's voxels form a box, that box. Else the middle leaf, grown by full leaves while it remains a box;
/// empty if that leaf is not full. Immutable; any number of threads may read.
class WindowBox {
  public:
    WindowBox(const Domain& domain, const LeafWindow& window);

    /// Whether all of the domain's voxels in the window are in the box.
    [[nodiscard]] bool isExact() const { return mIsExact; }
    /// Whether the domain has every voxel of the window.
    [[nodiscard]] bool isWindow() const { return mIsWindow; }

    /// Lanes of the cells whose corners are all in the box. @param x, y, z lowest corner
    [[nodiscard]] VDBLIC_INLINE Int8 holdsCell(Int8 x, Int8 y, Int8 z) const
    {
        return (x >= mFirst[0]) & (x < mLast[0]) & (y >= mFirst[1]) & (y < mLast[1]) & (z >= mFirst[2]) &
               (z < mLast[2]);
    }
    /// Lanes of the coordinates in the box. @param axis 0 to 2
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
