#pragma once

#include "vdblic/core/paging.h"
#include "vdblic/field/domain.h"
#include "vdblic/field/domain_rows.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"

#include <openvdb/tree/LeafManager.h>

#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cstddef>

namespace vdblic {

/// One number per value of a row. A struct, because a bare vector type loses its alignment as a template argument.
struct NumberRow {
    Float8 numbers{};
};
VDBLIC_INLINE NumberRow larger(const NumberRow& a, const NumberRow& b)
{
    return {a.numbers > b.numbers ? a.numbers : b.numbers};
}
VDBLIC_INLINE Vector8 larger(const Vector8& a, const Vector8& b)
{
    return {a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y, a.z > b.z ? a.z : b.z};
}

[[nodiscard]] inline float largestLane(Float8 numbers)
{
    float lanes[8];
    storeLanes(numbers, lanes);
    return *std::max_element(lanes, lanes + 8);
}

/// The active values of a row, 0 elsewhere. @param mask of the leaf
VDBLIC_INLINE NumberRow activeValues(const Domain::Mask& mask, const float* values, int row)
{
    return {activeRow(mask, row) ? loadRow(values, row) : Float8{}};
}
VDBLIC_INLINE Vector8 activeValues(const Domain::Mask& mask, const openvdb::Vec3f* values, int row)
{
    return select(activeRow(mask, row), loadVectors(values[std::ptrdiff_t(row) * LeafVoxel::kDim].asPointer()),
                  Vector8{});
}
/// A row of one value.
VDBLIC_INLINE NumberRow rowOf(float value)
{
    return {broadcast8(value)};
}
VDBLIC_INLINE Vector8 rowOf(const openvdb::Vec3f& value)
{
    return {broadcast8(value[0]), broadcast8(value[1]), broadcast8(value[2])};
}

/// Raise the results to those of a leaf's rows; otherwise as largestValues().
template<typename Value, typename Row, typename Measure>
VDBLIC_KERNEL void addRows(const Domain::Mask& mask, const Value* values, const Measure& measure, Row& most)
{
    Row largest = most;
    for (int row = 0; row < LeafVoxel::kRows; ++row)
        largest = larger(measure(activeValues(mask, values, row)), largest);
    most = largest;
}

/// The largest results of `measure` over the active voxels and tiles of a tree, lane by lane of its rows. Leaves are
/// visited in parallel.
///
/// @param measure maps a row's values to a NumberRow or Vector8; smallest, 0, for values of 0
template<typename TreeT, typename Measure>
[[nodiscard]] auto largestValues(const TreeT& tree, const Measure& measure)
{
    using Row = decltype(measure(rowOf(tree.background())));
    const openvdb::tree::LeafManager<const TreeT> leaves(tree);
    Row largest = tbb::parallel_reduce(
        leaves.leafRange(), Row{},
        [&](const auto& range, Row most) {
            for (auto leaf = range.begin(); leaf; ++leaf) {
                paging::breathe(paging::kLeafBytes);
                addRows(leaf->valueMask(), leaf->buffer().data(), measure, most);
            }
            return most;
        },
        [](const Row& a, const Row& b) { return larger(a, b); });
    auto tile = tree.cbeginValueOn();
    tile.setMaxDepth(tile.getLeafDepth() - 1);
    for (; tile; ++tile)
        largest = larger(largest, measure(rowOf(*tile)));
    return largest;
}

} // namespace vdblic
