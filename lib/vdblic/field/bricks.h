#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/vector.h"

#include <tbb/parallel_for.h>

#include <memory>

namespace vdblic {

/// Eight numbers stored at a voxel, loaded and interpolated together.
struct alignas(32) Record {
    float values[8];
};

/// What fast sampling is made of: for each leaf a brick of 9³ records, its 8³ voxels and the next voxel in each
/// positive direction, so that a cell's eight corners always lie in one brick.
///
/// Records are premultiplied by their voxel's coverage (1 if it has a value, 0 if not), and the coverage is one of
/// the eight numbers: the interpolated values over the interpolated coverage are then the mean over the corners
/// that have values. At the rim of a domain this continues the values of the last voxels, as clamping does.
///
/// Filling is done once; any number of threads may sample.
class Bricks {
  public:
    static constexpr int kDim = 9;
    static constexpr int kSize = kDim * kDim * kDim;

    /// Fill a brick for each leaf of a domain, in parallel.
    /// @param fill called as fill(leaf, records) with the leaf's number and its kSize records, x slowest, to be set
    template<typename Fill>
    void fill(std::shared_ptr<const Domain> domain, const Fill& fill)
    {
        mDomain = std::move(domain);
        const std::size_t records = mDomain->leafCount() * kSize;
        if (records > mCapacity) {
            mRecords.reset(); // first, so that old and new never stand side by side
            mRecords.reset(new Record[records]);
            mCapacity = records;
        }
        tbb::parallel_for(std::size_t(0), mDomain->leafCount(),
                          [&](std::size_t leaf) { fill(leaf, mRecords.get() + leaf * kSize); });
    }

    /// A cell of the grid of voxel centres, and a place in it.
    struct Cell {
        const Record* corner; ///< the record at the cell's lowest corner; null outside every brick
        Float4 fraction;      ///< the place, 0 to 1 along each axis
    };

    /// @param position in index space, voxel centres at integers; the fourth lane is ignored
    [[nodiscard]] VDBLIC_INLINE Cell locate(Float4 position) const
    {
        Int4 base = floorToInt(position);
        int leaf = mDomain->findLeaf(base);
        if (__builtin_expect(leaf < 0, 0)) {
            leaf = clampToLeaf(position, base);
            if (leaf < 0) return {nullptr, position};
        }
        const int record = ((base[0] & 7) * kDim + (base[1] & 7)) * kDim + (base[2] & 7);
        return {mRecords.get() + std::size_t(leaf) * kSize + std::size_t(record),
                position - __builtin_convertvector(base, Float4)};
    }

    /// Trilinear interpolation of the eight premultiplied numbers.
    [[nodiscard]] VDBLIC_INLINE static Float8 interpolate(const Cell& cell)
    {
        const Float8 z = broadcast8(cell.fraction[2]);
        const Float8 y = broadcast8(cell.fraction[1]);
        const Float8 x = broadcast8(cell.fraction[0]);
        const auto corner = [&](int i) { return *reinterpret_cast<const Float8*>(cell.corner[i].values); };
        const auto mix = [](Float8 a, Float8 b, Float8 t) { return a + (b - a) * t; };
        constexpr int kY = kDim, kX = kDim * kDim;
        return mix(mix(mix(corner(0), corner(1), z), mix(corner(kY), corner(kY + 1), z), y),
                   mix(mix(corner(kX), corner(kX + 1), z), mix(corner(kX + kY), corner(kX + kY + 1), z), y), x);
    }

    [[nodiscard]] const Domain& domain() const { return *mDomain; }
    [[nodiscard]] const std::shared_ptr<const Domain>& sharedDomain() const { return mDomain; }

  private:
    /// In the half voxel below a leaf that has no leaf before it, the first voxels' values go on: move the position up
    /// to them, along as few axes as will do. @return the leaf then, or −1
    [[gnu::noinline]] int clampToLeaf(Float4& position, Int4& base) const
    {
        const Int4 nearest = voxelOf(position);
        for (int axes : {1, 2, 4, 3, 5, 6, 7}) {
            Int4 moved = base;
            for (int axis = 0; axis < 3; ++axis) {
                if (axes >> axis & 1) moved[axis] = nearest[axis];
            }
            const int leaf = mDomain->findLeaf(moved);
            if (leaf < 0) continue;
            for (int axis = 0; axis < 3; ++axis) {
                if (moved[axis] != base[axis]) position[axis] = float(moved[axis]);
            }
            base = moved;
            return leaf;
        }
        return -1;
    }

    std::shared_ptr<const Domain> mDomain;
    std::unique_ptr<Record[]> mRecords;
    std::size_t mCapacity = 0;
};

/// Visit the 9³ voxels of a brick in a tree: visit(record index, value, active), values as the tree has them.
template<typename TreeT, typename Visit>
void visitBrick(const TreeT& tree, const openvdb::Coord& origin, const Visit& visit)
{
    for (int part = 0; part < 8; ++part) {
        const openvdb::Coord begin((part >> 2) & 1 ? 8 : 0, (part >> 1) & 1 ? 8 : 0, part & 1 ? 8 : 0);
        const openvdb::Coord end(begin[0] ? 9 : 8, begin[1] ? 9 : 8, begin[2] ? 9 : 8);
        const auto* leaf = tree.probeConstLeaf(origin + begin);
        typename TreeT::ValueType tile{};
        const bool tileActive = !leaf && tree.probeValue(origin + begin, tile);
        for (int x = begin[0]; x < end[0]; ++x) {
            for (int y = begin[1]; y < end[1]; ++y) {
                for (int z = begin[2]; z < end[2]; ++z) {
                    const unsigned offset = Domain::offset(Int4{x, y, z, 0});
                    const int record = (x * Bricks::kDim + y) * Bricks::kDim + z;
                    if (leaf) {
                        visit(record, leaf->getValue(offset), leaf->isValueOn(offset));
                    } else {
                        visit(record, tile, tileActive);
                    }
                }
            }
        }
    }
}

} // namespace vdblic
