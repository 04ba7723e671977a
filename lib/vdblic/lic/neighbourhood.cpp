#include "vdblic/lic/neighbourhood.h"

#include "vdblic/field/domain_rows.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/field/vector.h"

#include <cstdint>

namespace vdblic {
namespace {

constexpr int kInnerDim = LeafVoxel::kDim;
constexpr int kDim = kInnerDim + 2; // a leaf with a rim of one voxel

/// One number for each voxel of a leaf and its rim, x slowest.
using Cube = float[kDim][kDim][kDim];

/// Fill a cube. @param row called as row(leaf, row number), returns 8 numbers; leaf −1 is outside
template<typename RowOf>
VDBLIC_INLINE void gather(const LeafWindow& window, const RowOf& row, Cube& cube)
{
    for (int x = -1; x <= kInnerDim; ++x) {
        for (int y = -1; y <= kInnerDim; ++y) {
            float* to = cube[x + 1][y + 1];
            const int slot = LeafWindow::slot(LeafVoxel::leafCoordinate(x) + 1, LeafVoxel::leafCoordinate(y) + 1, 0);
            const int* leaves = &window.leaves[std::size_t(slot)];
            const int number = LeafVoxel::row(x, y);
            to[0] = row(leaves[0], number)[kInnerDim - 1];
            const Float8 middle = row(leaves[1], number);
            __builtin_memcpy(to + 1, &middle, sizeof middle);
            to[kDim - 1] = row(leaves[2], number)[0];
        }
    }
}

/// Weighted 3³ sums, one axis after the other. @param sums of the 512 voxels
VDBLIC_INLINE void sum(const Cube& cube, float centre, float* sums)
{
    const auto load = [](const float* from) {
        Float8 row;
        __builtin_memcpy(&row, from, sizeof row);
        return row;
    };
    Float8 planes[kDim][kInnerDim];
    for (int x = 0; x < kDim; ++x) {
        Float8 rows[kDim];
        for (int y = 0; y < kDim; ++y) {
            const float* row = cube[x][y];
            rows[y] = load(row) + load(row + 1) * centre + load(row + 2);
        }
        for (int y = 0; y < kInnerDim; ++y)
            planes[x][y] = rows[y] + rows[y + 1] * centre + rows[y + 2];
    }
    for (int x = 0; x < kInnerDim; ++x) {
        for (int y = 0; y < kInnerDim; ++y) {
            const Float8 total = planes[x][y] + planes[x + 1][y] * centre + planes[x + 2][y];
            const int row = x * kInnerDim + y;
            storeRow(total, sums, row);
        }
    }
}

VDBLIC_KERNEL void sumLeaf(const Domain& domain, const LeafValues<float>& values, const LeafWindow& window,
                           float centre, NeighbourSums& sums)
{
    alignas(32) Cube cube;
    const auto valueRow = [&](int leaf, int number) {
        return leaf >= 0 ? loadRow(values[std::size_t(leaf)], number) : Float8{};
    };
    gather(window, valueRow, cube);
    sum(cube, centre, sums.value.data());

    bool whole = true;
    for (int slot = 0; slot < LeafWindow::kElsewhere; ++slot) {
        const int leaf = window.leaves[std::size_t(slot)];
        whole = whole && leaf >= 0 && domain.mask(std::size_t(leaf)).isOn();
    }
    if (whole) {
        sums.weight.fill((2 + centre) * (2 + centre) * (2 + centre));
        return;
    }
    const auto maskRow = [&](int leaf, int number) {
        const int bits = leaf < 0 ? 0 : domain.mask(std::size_t(leaf)).getWord<std::uint8_t>(openvdb::Index(number));
        const Int8 on = maskOf(unsigned(bits));
        return on ? broadcast8(1) : Float8{};
    };
    gather(window, maskRow, cube);
    sum(cube, centre, sums.weight.data());
}

} // namespace

NeighbourSums sumNeighbours(const Domain& domain, const LeafValues<float>& values, std::size_t leaf, float centre)
{
    NeighbourSums sums;
    sumLeaf(domain, values, LeafWindow(domain, domain.origin(leaf)), centre, sums);
    return sums;
}

} // namespace vdblic
