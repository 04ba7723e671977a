#pragma once

#include "vdblic/field/period.h"
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
/// Cells do not depend on the domain. In a periodic box, points near a side are there beyond the opposite one too. Any
/// number of threads may search, each with its own Look, but not while points are added.
class NeighbourhoodGrid {
  public:
    explicit NeighbourhoodGrid(const std::array<float, 3>& spacing, const Period& period = {})
        : mScale{1 / spacing[0], 1 / spacing[1], 1 / spacing[2]}, mPeriod(period), mCells(-1), mEnter(mCells)
    {
    }

    /// The cell of a position.
    [[nodiscard]] openvdb::Coord cell(const std::array<float, 3>& position) const
    {
        const Point at = scaled(position);
        return {int(std::floor(at[0])), int(std::floor(at[1])), int(std::floor(at[2]))};
    }

    /// Add a point. @param position in the periodic box  @param number passed to the predicate of anyWithin()
    void add(const std::array<float, 3>& position, std::uint32_t number) { addImages(position, number, 0); }
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
            const auto anyIn = [&](const openvdb::Coord& cell) {
                for (int i = mCells.getValue(cell); i >= 0;) {
                    const Entry& entry = mGrid.mPoints[std::size_t(i)];
                    if (squaredDistance(at, entry.at) < distance * distance && is(entry.number)) return true;
                    i = entry.next;
                }
                return false;
            };
            const openvdb::Coord own = mGrid.cell(position);
            if (anyIn(own)) return true; // the likeliest
            for (openvdb::CoordBBox::Iterator<true> cell(openvdb::CoordBBox(first, last)); cell; ++cell) {
                if (*cell != own && anyIn(*cell)) return true;
            }
            return false;
        }

      private:
        const NeighbourhoodGrid& mGrid;
        openvdb::tree::ValueAccessor<const openvdb::Int32Tree> mCells;
    };

  private:
    using Point = std::array<float, 3>;

    /// Add a point, and its images that are at most a spacing outside the box along this and the following axes.
    void addImages(const Point& position, std::uint32_t number, std::size_t axis)
    {
        if (axis == 3) return addOne(position, number);
        addImages(position, number, axis + 1);
        const auto size = float(mPeriod.size[int(axis)]), begin = float(mPeriod.first[int(axis)]) - 0.5f;
        if (size == 0) return;
        const float spacing = 1 / mScale[axis];
        for (const float way : {-size, size}) {
            Point image = position;
            image[axis] += way;
            if (image[axis] >= begin - spacing && image[axis] <= begin + size + spacing)
                addImages(image, number, axis + 1);
        }
    }

    void addOne(const Point& position, std::uint32_t number)
    {
        const openvdb::Coord cell = this->cell(position);
        mPoints.push_back({scaled(position), number, mEnter.getValue(cell)});
        mEnter.setValue(cell, std::int32_t(mPoints.size()) - 1);
    }

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
    Period mPeriod;
    std::vector<Entry> mPoints;
    openvdb::Int32Tree mCells; // the last point added to each cell, or −1
    openvdb::tree::ValueAccessor<openvdb::Int32Tree> mEnter;
};

} // namespace vdblic
