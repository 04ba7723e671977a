#pragma once

#include <openvdb/tree/LeafManager.h>

#include <tbb/parallel_reduce.h>

namespace vdblic {

/// The largest result of `measure` over the active voxels and tiles of a tree. Leaves are visited in parallel.
///
/// @param least   the result for a tree without active values; no measure may be less
/// @param measure value → T
/// @param larger  the larger of two T, with any order of its arguments
template<typename TreeT, typename T, typename Measure, typename Larger>
[[nodiscard]] T largestValue(const TreeT& tree, const T& least, const Measure& measure, const Larger& larger)
{
    const openvdb::tree::LeafManager<const TreeT> leaves(tree);
    T largest = tbb::parallel_reduce(
        leaves.leafRange(), least,
        [&](const auto& range, T most) {
            for (auto leaf = range.begin(); leaf; ++leaf) {
                const auto* values = leaf->buffer().data();
                if (leaf->isDense()) { // vectorized by the compiler
                    for (openvdb::Index i = 0; i < TreeT::LeafNodeType::SIZE; ++i)
                        most = larger(most, measure(values[i]));
                } else {
                    for (auto value = leaf->cbeginValueOn(); value; ++value)
                        most = larger(most, measure(*value));
                }
            }
            return most;
        },
        larger);
    auto tile = tree.cbeginValueOn();
    tile.setMaxDepth(tile.getLeafDepth() - 1);
    for (; tile; ++tile)
        largest = larger(largest, measure(*tile));
    return largest;
}

} // namespace vdblic
