#pragma once

#include "vdblic/core/paging.h"
#include "vdblic/field/domain.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/field/vector.h"

#include <openvdb/openvdb.h>
#include <tbb/parallel_for.h>

#include <array>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace vdblic {

namespace bricks {

template<int kNumbers>
struct Numbers;
template<>
struct Numbers<2> {
    using Vector = Float2;
};
template<>
struct Numbers<4> {
    using Vector = Float4;
};
template<>
struct Numbers<8> {
    using Vector = Float8;
};

} // namespace bricks

/// Fast sampling of a domain's values. For each leaf a brick of 9³ records: its 8³ voxels and the next voxel in each
/// positive direction, so that a cell's eight corners always lie in one brick.
///
/// A record is two, four or eight numbers, loaded and interpolated together. Records are premultiplied by their voxel's
/// coverage (1 if it has a value, 0 if not), and the coverage is one of the numbers: interpolated values over
/// interpolated coverage are the mean over the corners that have values. At the rim of a domain this continues the
/// values of the last voxels, as clamping does.
///
/// Only leaves whose bricks are filled can be sampled. Any number of threads may sample, and none while bricks are
/// filled or released.
template<int kNumbers>
class BricksOf {
  public:
    using Vector = typename bricks::Numbers<kNumbers>::Vector;
    struct alignas(sizeof(Vector)) Record {
        float values[kNumbers];
    };
    static constexpr int kDim = LeafVoxel::kDim + 1;
    static constexpr int kSize = kDim * kDim * kDim;

    /// The index in its brick of a voxel's record. @param x, y, z coordinates in the brick, 0 to kDim − 1
    [[nodiscard]] VDBLIC_INLINE static constexpr int index(int x, int y, int z) { return (x * kDim + y) * kDim + z; }

    /// Adopt a domain; none of its leaves has a brick yet.
    void cover(std::shared_ptr<const Domain> domain)
    {
        mDomain = std::move(domain);
        mBricks = std::vector<std::unique_ptr<Record[]>>(mDomain->leafCount());
    }

    /// Fill the bricks of the given leaves, in parallel.
    /// @param leaves range of leaf numbers
    /// @param fill   called as fill(leaf number, records); sets the brick's kSize records, x slowest
    template<typename Leaves, typename Fill>
    void fill(const Leaves& leaves, const Fill& fill)
    {
        tbb::parallel_for(std::size_t(0), leaves.size(), [&](std::size_t i) {
            paging::breathe(paging::kLeafBytes);
            const std::size_t leaf = leaves[i];
            mBricks[leaf].reset(new Record[kSize]);
            fill(leaf, mBricks[leaf].get());
        });
    }

    /// Free the bricks of the given leaves.
    template<typename Leaves>
    void release(const Leaves& leaves)
    {
        for (const std::size_t leaf : leaves)
            mBricks[leaf].reset();
    }

    /// The bricks of a leaf and its 26 neighbours, to find those of eight positions at once.
    struct Window {
        LeafWindow leaves;
        std::array<const float*, LeafWindow::kElsewhere + 1> bricks{}; ///< records in each slot; null without a brick
    };
    /// @param origin of the leaf. The window is valid until one of its bricks is filled or released.
    [[nodiscard]] Window window(const openvdb::Coord& origin) const
    {
        Window result{LeafWindow(*mDomain, origin)};
        for (std::size_t slot = 0; slot < LeafWindow::kElsewhere; ++slot) {
            const int leaf = result.leaves.leaves[slot];
            if (leaf >= 0 && mBricks[std::size_t(leaf)]) result.bricks[slot] = record(leaf, 0)->values;
        }
        return result;
    }

    /// A cell of the grid of voxel centres, and a position in it.
    struct Cell {
        const Record* corner; ///< the record at the cell's lowest corner; null outside every brick
        Float4 fraction;      ///< the position, 0 to 1 along each axis
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
        return {record(leaf, index(LeafVoxel::local(base[0]), LeafVoxel::local(base[1]), LeafVoxel::local(base[2]))),
                position - __builtin_convertvector(base, Float4)};
    }

    /// locate(), out of line: for the rare position outside its expected window.
    [[nodiscard]] [[gnu::noinline]] Cell locateAnywhere(Float4 position) const { return locate(position); }

    /// A record of a leaf's brick. @param index of the record, see index()
    [[nodiscard]] VDBLIC_INLINE const Record* record(int leaf, int index) const
    {
        return mBricks[std::size_t(leaf)].get() + index;
    }

    /// Trilinear interpolation of the premultiplied numbers.
    [[nodiscard]] VDBLIC_INLINE static Vector interpolate(const Cell& cell)
    {
        float weights[8];
        weightCorners(cell.fraction[0], cell.fraction[1], cell.fraction[2],
                      [&](int corner, float weight) { weights[corner] = weight; });
        return weigh(cell.corner->values, [&](int corner) { return weights[corner]; });
    }

    /// Interpolate at eight positions.
    /// @param window in which the positions are expected; others are slower
    /// @param lanes  bits of the lanes to interpolate; other rows are zero, as are rows outside every brick
    VDBLIC_INLINE void interpolate(const Window& window, const Vector8& position, unsigned lanes,
                                   Vector (&rows)[8]) const
    {
        const Int8 x = floorToInt(position.x), y = floorToInt(position.y), z = floorToInt(position.z);
        static_assert(kDim == 9);
        const auto nine = [](Int8 n) { return (n << 3) + n; }; // 9 n without a multiplication
        alignas(32) int slots[8], lowest[8];
        alignas(32) float weights[8][8]; // by corner and lane
        storeLanes(window.leaves.slots(x, y, z), slots);
        storeLanes((nine(nine(LeafVoxel::local(x)) + LeafVoxel::local(y)) + LeafVoxel::local(z)) * kNumbers, lowest);
        const auto fraction = [](Float8 p, Int8 base) { return p - __builtin_convertvector(base, Float8); };
        weightCorners(fraction(position.x, x), fraction(position.y, y), fraction(position.z, z),
                      [&](int corner, Float8 weight) { storeLanes(weight, weights[corner]); });
        for (int i = 0; i < 8; ++i) {
            Vector row{};
            if (lanes >> i & 1) {
                const float* const brick = window.bricks[std::size_t(slots[i])];
                if (__builtin_expect(brick != nullptr, 1)) {
                    row = weigh(brick + unsigned(lowest[i]), [&](int corner) { return weights[corner][i]; });
                } else if (const Cell cell = locateAnywhere(position.lane(i)); cell.corner) {
                    row = interpolate(cell);
                }
            }
            rows[i] = row;
        }
    }

    [[nodiscard]] const Domain& domain() const { return *mDomain; }
    [[nodiscard]] const std::shared_ptr<const Domain>& sharedDomain() const { return mDomain; }

  private:
    /// The weights of a cell's eight corners, z the fastest: put(corner, weight).
    template<typename T, typename Put>
    VDBLIC_INLINE static void weightCorners(T x, T y, T z, const Put& put)
    {
        const T x0 = 1 - x, y0 = 1 - y, z0 = 1 - z;
        const auto pair = [&](int corner, T xy) {
            put(corner, xy * z0);
            put(corner + 1, xy * z);
        };
        pair(0, x0 * y0);
        pair(2, x0 * y);
        pair(4, x * y0);
        pair(6, x * y);
    }
    /// @param lowest the record at a cell's lowest corner
    template<typename WeightOf>
    VDBLIC_INLINE static Vector weigh(const float* lowest, const WeightOf& weightOf)
    {
        constexpr int kX = index(1, 0, 0), kY = index(0, 1, 0);
        const auto part = [&](int corner, int offset) {
            return *reinterpret_cast<const Vector*>(lowest + std::ptrdiff_t(offset) * kNumbers) * weightOf(corner);
        };
        return ((part(0, 0) + part(1, 1)) + (part(2, kY) + part(3, kY + 1))) +
               ((part(4, kX) + part(5, kX + 1)) + (part(6, kX + kY) + part(7, kX + kY + 1)));
    }

    /// Where no leaf comes before, the values of a leaf's first voxels extend half a voxel below it. Move such a
    /// position up to the voxels' centres, along as few axes as necessary. @return the leaf, or −1 outside
    [[gnu::noinline]] int clampToLeaf(Float4& position, Int4& base) const
    {
        static constexpr Int4 kAxes[] = {{-1, 0, 0, 0},  {0, -1, 0, 0},  {0, 0, -1, 0},  {-1, -1, 0, 0},
                                         {-1, 0, -1, 0}, {0, -1, -1, 0}, {-1, -1, -1, 0}};
        const Int4 nearest = voxelOf(position), fixed = nearest == base;
        for (const Int4 axes : kAxes) {
            const auto unmoved = reinterpret_cast<Long2>(axes & fixed);
            if ((unmoved[0] | unmoved[1]) != 0) continue; // same as without the fixed axes
            const Int4 moved = axes ? nearest : base;
            const int leaf = mDomain->findLeaf(moved);
            if (leaf < 0) continue;
            position = axes ? __builtin_convertvector(nearest, Float4) : position;
            base = moved;
            return leaf;
        }
        return -1;
    }

    std::shared_ptr<const Domain> mDomain;
    std::vector<std::unique_ptr<Record[]>> mBricks; // of each leaf; null if not filled
};

using Bricks = BricksOf<8>;
using Record = Bricks::Record;

/// Visit the 9³ voxels of a leaf's brick in a tree.
/// @param origin of the leaf
/// @param visit  callback visit(index of the record, value, active)
template<typename TreeT, typename Visit>
void visitBrick(const TreeT& tree, const openvdb::Coord& origin, const Visit& visit)
{
    constexpr int kLeafDim = LeafVoxel::kDim;
    for (int part = 0; part < 8; ++part) {
        const openvdb::Coord begin(part & 4 ? kLeafDim : 0, part & 2 ? kLeafDim : 0, part & 1 ? kLeafDim : 0);
        const auto endOf = [](int first) { return first == 0 ? LeafVoxel::kDim : Bricks::kDim; };
        const openvdb::Coord end(endOf(begin[0]), endOf(begin[1]), endOf(begin[2]));
        const auto forEachVoxel = [&](const auto& visitVoxel) {
            for (int x = begin[0]; x < end[0]; ++x) {
                for (int y = begin[1]; y < end[1]; ++y) {
                    const int record = Bricks::index(x, y, 0);
                    const auto row = unsigned(LeafVoxel::offset(x, y, 0));
                    for (int z = begin[2]; z < end[2]; ++z)
                        visitVoxel(record + z, row + unsigned(LeafVoxel::local(z)));
                }
            }
        };
        if (const auto* leaf = tree.probeConstLeaf(origin + begin)) {
            const auto* values = leaf->buffer().data();
            if (leaf->isDense()) {
                forEachVoxel([&](int record, unsigned offset) { visit(record, values[offset], true); });
            } else {
                forEachVoxel(
                    [&](int record, unsigned offset) { visit(record, values[offset], leaf->isValueOn(offset)); });
            }
        } else {
            typename TreeT::ValueType constant{}; // of an OpenVDB tile or the background
            const bool active = tree.probeValue(origin + begin, constant);
            forEachVoxel([&](int record, unsigned) { visit(record, constant, active); });
        }
    }
}

} // namespace vdblic
