#pragma once

#include <openvdb/openvdb.h>
#include <openvdb/tree/LeafManager.h>
#include <tbb/parallel_reduce.h>

namespace vdblic {

/// Fold the active values of a tree, those of OpenVDB's tiles once each, in parallel.
///
/// @param identity result for no values
/// @param fold     callback fold(result, value), returns the result with one more value
/// @param join     callback join(result, result), returns the result of both. If it is associative and commutative, the
///                 result does not depend on the number of threads.
template<typename Result, typename TreeT, typename Fold, typename Join>
[[nodiscard]] Result foldActiveValues(const TreeT& tree, const Result& identity, const Fold& fold, const Join& join)
{
    Result ofTiles = identity;
    auto tile = tree.cbeginValueOn();
    tile.setMaxDepth(tile.getLeafDepth() - 1);
    for (; tile; ++tile)
        ofTiles = fold(ofTiles, *tile);

    using Leaves = openvdb::tree::LeafManager<const TreeT>;
    const Leaves leaves(tree);
    const Result ofLeaves = tbb::parallel_reduce(
        leaves.leafRange(), identity,
        [&](const typename Leaves::LeafRange& range, Result result) {
            for (auto leaf = range.begin(); leaf; ++leaf) {
                const auto* values = leaf->buffer().data();
                if (leaf->isDense()) {
                    for (openvdb::Index i = 0; i < TreeT::LeafNodeType::SIZE; ++i)
                        result = fold(result, values[i]);
                } else {
                    for (auto value = leaf->cbeginValueOn(); value; ++value)
                        result = fold(result, *value);
                }
            }
            return result;
        },
        join);
    return join(ofTiles, ofLeaves);
}

} // namespace vdblic
