#include "vdblic/compare/point_difference.h"

#include "vdblic/compare/measure.h"
#include "vdblic/compare/point_list.h"
#include "vdblic/core/errors.h"

#include <fmt/format.h>
#include <openvdb/points/PointDataGrid.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace vdblic::compare {
namespace {

using namespace openvdb;

struct Pair {
    std::uint64_t a, b; // indices of points
};

constexpr const char* kId = "id";

std::optional<std::vector<std::int64_t>> idsOf(const PointList& points)
{
    const std::string type = points.typeOf(kId);
    const auto widen = [&](const auto& ids) { return std::vector<std::int64_t>(ids.get(), ids.get() + points.size()); };
    if (type == "int32") return widen(points.values<std::int32_t>(kId));
    if (type == "int64") return widen(points.values<std::int64_t>(kId));
    return std::nullopt;
}

/// Indices of points sorted by id, then by index.
std::vector<std::uint64_t> sorted(const std::vector<std::int64_t>& ids)
{
    std::vector<std::uint64_t> order(ids.size());
    std::iota(order.begin(), order.end(), std::uint64_t(0));
    tbb::parallel_sort(order.begin(), order.end(),
                       [&](std::uint64_t a, std::uint64_t b) { return ids[a] != ids[b] ? ids[a] < ids[b] : a < b; });
    return order;
}

std::vector<Pair> pairsById(const std::vector<std::int64_t>& idsA, const std::vector<std::int64_t>& idsB)
{
    const auto orderA = sorted(idsA), orderB = sorted(idsB);
    std::vector<Pair> pairs;
    for (std::size_t a = 0, b = 0; a < orderA.size() && b < orderB.size();) {
        const std::int64_t idA = idsA[orderA[a]], idB = idsB[orderB[b]];
        if (idA == idB) pairs.push_back({orderA[a], orderB[b]});
        if (idA <= idB) ++a;
        if (idB <= idA) ++b;
    }
    return pairs;
}

std::vector<Pair> pairsByVoxel(const PointList& a, const PointList& b)
{
    std::map<Coord, std::size_t> leafOfB;
    for (std::size_t i = 0; i < b.leaves().size(); ++i)
        leafOfB[b.leaves()[i]->origin()] = i;
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < a.leaves().size(); ++i) {
        const auto found = leafOfB.find(a.leaves()[i]->origin());
        if (found == leafOfB.end()) continue;
        const PointLeaf &leafA = *a.leaves()[i], &leafB = *b.leaves()[found->second];
        std::uint64_t beginA = 0, beginB = 0;
        for (Index n = 0; n < PointLeaf::SIZE; ++n) {
            const std::uint64_t endA = leafA.getValue(n), endB = leafB.getValue(n);
            for (std::uint64_t k = 0; k < std::min(endA - beginA, endB - beginB); ++k) {
                pairs.push_back({a.firstOf(i) + beginA + k, b.firstOf(found->second) + beginB + k});
            }
            beginA = endA;
            beginB = endB;
        }
    }
    return pairs;
}

/// The matched points of two grids.
struct Matched {
    const PointList &a, &b;
    std::vector<Pair> pairs;
    std::unique_ptr<Vec3d[]> positionsA, positionsB;
};

/// Compares the values of matched points block by block, `stride` values a point.
template<typename T>
class PairMeter {
  public:
    PairMeter(const T* a, const T* b, std::size_t stride, const std::vector<Pair>& pairs, const Tolerances& tolerances)
        : mA(a), mB(b), mStride(stride), mPairs(pairs), mTolerances(tolerances)
    {
    }

    [[nodiscard]] std::size_t count() const { return mPairs.size() * mStride; }
    [[nodiscard]] const T& a(std::size_t n) const { return mA[mPairs[n / mStride].a * mStride + n % mStride]; }
    [[nodiscard]] const T& b(std::size_t n) const { return mB[mPairs[n / mStride].b * mStride + n % mStride]; }

    void operator()(std::size_t block, ValueSums& sums)
    {
        const std::size_t first = block * kBlockValues;
        mBlock.compared = {};
        for (std::size_t n = 0; n < std::min(kBlockValues, count() - first); ++n) {
            mBufferA[n] = a(first + n);
            mBufferB[n] = b(first + n);
            setOn(mBlock.compared, n);
        }
        measureBlock(mBufferA.data(), mBufferB.data(), mBlock);
        addBlock(sums, mBlock, mTolerances, [&](std::size_t n) { return ValueIndex{std::int64_t(first + n), 0, 0}; });
    }

  private:
    const T *mA, *mB;
    std::size_t mStride;
    const std::vector<Pair>& mPairs;
    Tolerances mTolerances;
    ErrorBlock mBlock;
    std::array<T, kBlockValues> mBufferA{}, mBufferB{};
};

template<typename T>
ValueDifference compareValues(const T* a, const T* b, std::size_t stride, const Matched& points,
                              const CompareParams& params)
{
    using M = Metric<T>;
    const auto makeMeter = [&] {
        return std::make_unique<PairMeter<T>>(a, b, stride, points.pairs, Tolerances{params.fail, params.relative});
    };
    const auto all = makeMeter();
    const ValueSums sums = sumInOrder((all->count() + kBlockValues - 1) / kBlockValues, makeMeter);

    const auto describe = [&](const ValueIndex& index) {
        const auto n = std::size_t(index[0]);
        VoxelDifference result;
        const std::uint64_t point = points.pairs[n / stride].a;
        const Coord voxel = points.a.voxelOf(point);
        const Vec3d& world = points.positionsA[point];
        result.index = {voxel.x(), voxel.y(), voxel.z()};
        result.world = {world.x(), world.y(), world.z()};
        result.a = M::text(all->a(n));
        result.b = M::text(all->b(n));
        result.error = errorBetween(all->a(n), all->b(n));
        return result;
    };
    ValueDifference result = finish(sums, M::kComponents, params.failPercent);
    if (sums.first) result.first = describe(*sums.first);
    if (sums.worst) result.worst = describe(*sums.worst);
    return result;
}

using AttributeTypes = TypeList<bool, int8_t, int16_t, int32_t, int64_t, float, double, Vec3i, Vec3f, Vec3d,
                                math::Quats, math::Quatd, Mat3s, Mat3d, Mat4s, Mat4d, std::string>;

ValueDifference compareAttribute(const std::string& name, const Matched& points, const CompareParams& params)
{
    if (name == "P") return compareValues(points.positionsA.get(), points.positionsB.get(), 1, points, params);
    const unsigned stride = points.a.strideOf(name);
    std::string type = points.a.typeOf(name);
    type.resize(std::min(type.find('['), type.size()));
    std::optional<ValueDifference> result;
    AttributeTypes::foreach ([&](auto example) {
        using T = decltype(example);
        if (type != typeNameAsString<T>()) return;
        const auto a = points.a.values<T>(name), b = points.b.values<T>(name);
        result = compareValues(a.get(), b.get(), stride, points, params);
    });
    if (!result) {
        throw InputError(fmt::format("grid '{}': attribute '{}' is of type {}, which cannot be compared",
                                     points.a.gridName(), name, points.a.typeOf(name)));
    }
    return *result;
}

std::set<std::string> namesOf(const std::vector<std::string>& a, const std::vector<std::string>& b)
{
    std::set<std::string> names(a.begin(), a.end());
    names.insert(b.begin(), b.end());
    return names;
}

void compareAttributes(const Matched& points, const CompareParams& params, PointDifference& result)
{
    for (const std::string& name : namesOf(points.a.attributes(), points.b.attributes())) {
        AttributeDifference difference{name, points.a.typeOf(name), points.b.typeOf(name), {}};
        if (difference.typeA == difference.typeB) difference.values = compareAttribute(name, points, params);
        result.attributes.push_back(std::move(difference));
    }
    const auto groupsA = points.a.groups(), groupsB = points.b.groups();
    for (const std::string& name : namesOf(groupsA, groupsB)) {
        const auto type = [&](const std::vector<std::string>& groups) {
            return std::find(groups.begin(), groups.end(), name) != groups.end() ? "group" : "";
        };
        AttributeDifference difference{name, type(groupsA), type(groupsB), {}};
        if (difference.typeA == difference.typeB) {
            const auto a = points.a.membership(name), b = points.b.membership(name);
            difference.values = compareValues(a.get(), b.get(), 1, points, params);
        }
        result.attributes.push_back(std::move(difference));
    }
}

} // namespace

PointDifference comparePoints(const points::PointDataGrid& a, const points::PointDataGrid& b,
                              const CompareParams& params)
{
    const PointList listA(a), listB(b);
    Matched points{listA, listB, {}, listA.positions(), listB.positions()};
    PointDifference result;
    result.countA = listA.size();
    result.countB = listB.size();
    const auto idsA = idsOf(listA), idsB = idsOf(listB);
    result.matchedById = idsA && idsB;
    points.pairs = result.matchedById ? pairsById(*idsA, *idsB) : pairsByVoxel(listA, listB);
    result.matched = points.pairs.size();
    result.onlyInA = result.countA - result.matched;
    result.onlyInB = result.countB - result.matched;
    const std::uint64_t alone = result.onlyInA + result.onlyInB;
    if (double(alone) > params.failPercent / 100. * double(alone + result.matched)) {
        result.countVerdict = Verdict::kDiffers;
    }
    // A grid without points has no attributes.
    if (result.countA > 0 && result.countB > 0) compareAttributes(points, params, result);
    return result;
}

} // namespace vdblic::compare
