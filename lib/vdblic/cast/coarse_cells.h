#pragma once

#include "vdblic/field/vector.h"
#include "vdblic/volume/record_sampling.h"

#include <openvdb/openvdb.h>

namespace vdblic {

/// A lattice of cubic cells in an index space, with values at the cells' centres, by x, then y, then z. Values are
/// interpolated between the centres, and constant past the outermost.
class CoarseCells {
  public:
    /// @param origin first voxel of the first cell  @param cell edge [voxels]  @param dim at least 2 cells a side
    CoarseCells(const openvdb::Coord& origin, const openvdb::Coord& dim, int cell) : mPerCell(1 / float(cell))
    {
        for (int axis = 0; axis < 3; ++axis) {
            mDim[axis] = dim[axis];
            mFirst[axis] = float(origin[axis]) + 0.5f * float(cell) - 0.5f;
            mLast[axis] = float(dim[axis] - 1);
        }
    }

    /// Eight places between the centres of cells.
    struct Places {
        Unsigned8 low; ///< numbers of the cells below, along each axis
        Float8 fraction[3];
    };
    /// @param position index space, by axis
    [[nodiscard]] VDBLIC_INLINE Places places(const Float8* position) const
    {
        Int8 cell[3];
        Places result;
        for (int axis = 0; axis < 3; ++axis) {
            // Cell centres lie at origin + cell · (c + ½) − ½.
            const Float8 at = (position[axis] - mFirst[axis]) * mPerCell;
            const Float8 least = at > 0 ? at : Float8{};
            const Float8 inside = least < mLast[axis] ? least : broadcast8(mLast[axis]);
            cell[axis] = __builtin_convertvector(inside, Int8);
            cell[axis] = cell[axis] < mDim[axis] - 2 ? cell[axis] : broadcastInt8(mDim[axis] - 2);
            result.fraction[axis] = inside - __builtin_convertvector(cell[axis], Float8);
        }
        result.low = Unsigned8((cell[0] * mDim[1] + cell[1]) * mDim[2] + cell[2]);
        return result;
    }
    /// @param values of all cells
    [[nodiscard]] VDBLIC_INLINE Float8 at(const float* values, const Places& places) const
    {
        return interpolate(values, places.low, mDim[2], mDim[1] * mDim[2], places.fraction);
    }
    [[nodiscard]] VDBLIC_INLINE Float8 at(const float* values, const Float8* position) const
    {
        return at(values, places(position));
    }

  private:
    int mDim[3];
    float mFirst[3], mLast[3], mPerCell; // the first cell's centre [voxels], the last one's [cells], cells in a voxel
};

} // namespace vdblic
