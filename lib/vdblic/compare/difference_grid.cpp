#include "vdblic/compare/compare.h"

#include "vdblic/compare/grid_types.h"
#include "vdblic/compare/value_metric.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>
#include <limits>
#include <type_traits>

namespace vdblic {
namespace {

using namespace openvdb;

/// The type of the grid that holds the differences of two grids.
template<typename GridT>
using DifferenceOf = std::conditional_t<
    std::is_same_v<GridT, Vec3SGrid>, Vec3SGrid,
    std::conditional_t<VecTraits<typename GridT::ValueType>::IsVec, Vec3DGrid,
                       std::conditional_t<std::is_same_v<GridT, FloatGrid> || std::is_same_v<GridT, BoolGrid> ||
                                              std::is_same_v<GridT, MaskGrid>,
                                          FloatGrid, DoubleGrid>>>;

template<typename S, typename T>
S scalarDifference(T a, T b)
{
    using M = compare::Metric<T>;
    if (M::same(a, b)) return S(0);
    const double error = M::error(a, b);
    return error <= std::numeric_limits<double>::max() ? S(error) : std::numeric_limits<S>::infinity();
}

template<typename D, typename T>
D difference(const T& a, const T& b)
{
    if constexpr (compare::Metric<T>::kComponents > 0) {
        using S = typename D::value_type;
        D result;
        for (int i = 0; i < D::size; ++i)
            result[i] = scalarDifference<S>(a[i], b[i]);
        return result;
    } else {
        return scalarDifference<D>(a, b);
    }
}

template<typename GridT>
GridBase::Ptr makeDifference(const GridT& a, const GridT& b)
{
    using Result = DifferenceOf<GridT>;
    using Tree = typename Result::TreeType;
    using D = typename Result::ValueType;
    auto tree = std::make_shared<Tree>(a.tree(), zeroVal<D>(), TopologyCopy());
    tree->topologyUnion(b.tree());

    const auto fill = [&](const auto& value, const auto& readA, const auto& readB) {
        const Coord voxel = value.getCoord();
        if constexpr (std::is_same_v<GridT, MaskGrid>) // its value is its activity
            value.setValue(D(readA.isValueOn(voxel) != readB.isValueOn(voxel)));
        else
            value.setValue(difference<D>(readA.getValue(voxel), readB.getValue(voxel)));
    };
    auto tile = tree->beginValueOn();
    tile.setMaxDepth(Tree::ValueOnIter::LEAF_DEPTH - 1);
    for (; tile; ++tile) // of the union, so a constant on both sides
        fill(tile, a.tree(), b.tree());
    std::vector<typename Tree::LeafNodeType*> leaves;
    tree->getNodes(leaves);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves.size()), [&](const auto& range) {
        const auto readA = a.getConstAccessor();
        const auto readB = b.getConstAccessor();
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            for (auto value = leaves[i]->beginValueOn(); value; ++value)
                fill(value, readA, readB);
        }
    });

    auto result = Result::create(tree);
    result->setName(a.getName());
    result->setTransform(a.transform().copy());
    return result;
}

} // namespace

GridBase::Ptr differenceGrid(const GridBase& a, const GridBase& b)
{
    GridBase::Ptr result;
    if (a.type() != b.type()) return result;
    a.apply<compare::GridTypes>([&](const auto& grid) {
        using Grid = std::decay_t<decltype(grid)>;
        result = makeDifference(grid, static_cast<const Grid&>(b));
    });
    return result;
}

} // namespace vdblic
