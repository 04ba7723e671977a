#pragma once

#include "vdblic/field/vector.h"

#include <openvdb/openvdb.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

/// Points in index space, binned in cells of one spacing, for neighbour search. Distances are in spacings.
///
/// Cells do not depend on the domain. Any number of threads may search, each with its own Look, but not while points
/// are added.
class NeighbourhoodGrid {
  public:
    explicit NeighbourhoodGrid(const std::array<float, 3>& spacing)
        : mScale{1 / spacing[0], 1 / spacing[1], 1 / spacing[2]}, mCells(-1), mEnter(mCells)
    {
    }

    /// The cell of a position.
    [[nodiscard]] openvdb::Coord cell(const std::array<float, 3>& position) const
    {
        const Point at = scaled(position);
        return {int(std::floor(at[0])), int(std::floor(at[1])), int(std::floor(at[2]))};
    }

    /// Add a point. @param number passed to the predicate of anyWithin()
    void add(const std::array<float, 3>& position, std::uint32_t number)
    {
        const openvdb::Coord cell = this->cell(position);
        mPoints.push_back({scaled(position), number, mEnter.getValue(cell)});
        mEnter.setValue(cell, std::int32_t(mPoints.size()) - 1);
    }

    /// One thread's view of the points.
    class Look {
      public:
        explicit Look(const NeighbourhoodGrid& grid) : mGrid(grid), mCells(grid.mCells) {}

        /// Whether is(number) is true for a point nearer than a distance. @param distance 1 at most
        template<typename Is>
        [[nodiscard]] bool anyWithin(const std::array<float, 3>& position, float distance, const Is& is) const
        {
            const Point at = mGrid.scaled(position);
            openvdb::Coord first, last;
            for (int axis = 0; axis < 3; ++axis) {
                first[axis] = int(std::floor(at[std::size_t(axis)] - distance));
                last[axis] = int(std::floor(at[std::size_t(axis)] + distance));
            }
            for (openvdb::CoordBBox::Iterator<true> cell(openvdb::CoordBBox(first, last)); cell; ++cell) {
                for (int i = mCells.getValue(*cell); i >= 0;) {
                    const Entry& entry = mGrid.mPoints[std::size_t(i)];
                    if (squaredDistance(at, entry.at) < distance * distance && is(entry.number)) return true;
                    i = entry.next;
                }
            }
            return false;
        }

      private:
        const NeighbourhoodGrid& mGrid;
        openvdb::tree::ValueAccessor<const openvdb::Int32Tree> mCells;
    };

  private:
    using Point = std::array<float, 3>;
    struct Entry {
        Point at; // [spacings]
        std::uint32_t number;
        std::int32_t next; // point of the same cell, or −1
    };

    [[nodiscard]] Point scaled(const std::array<float, 3>& position) const
    {
        return {position[0] * mScale[0], position[1] * mScale[1], position[2] * mScale[2]};
    }
    [[nodiscard]] static float squaredDistance(const Point& a, const Point& b)
    {
        const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
        return x * x + y * y + z * z;
    }

    std::array<float, 3> mScale;
    std::vector<Entry> mPoints;
    openvdb::Int32Tree mCells; // the last point added to each cell, or −1
    openvdb::tree::ValueAccessor<openvdb::Int32Tree> mEnter;
};

} // namespace vdblic
