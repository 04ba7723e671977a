#include "vdblic/methods/streaks/streak_state.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/lines/point_values.h"

#include <fmt/format.h>
#include <openvdb/points/PointConversion.h>
#include <openvdb/points/PointDataGrid.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>

namespace vdblic {
namespace {

using openvdb::Vec3f;
using openvdb::points::AttributeHandle;
using openvdb::points::PointDataGrid;
using PointLeaf = openvdb::points::PointDataTree::LeafNodeType;

constexpr const char *kGrid = "streaks", *kNode = "node", *kSlope = "slope", *kTime = "time", *kId = "id";
constexpr const char *kBorn = "born", *kRetired = "retired", *kKind = "kind";
constexpr const char *kSpacing = "spacing", *kTail = "tail", *kRefine = "refine";
constexpr std::int32_t kSlidIn = 1, kStopped = 2, kSource = 4; // bits of `kind`

/// All points of a grid, attribute by attribute, in one order.
struct Points {
    std::vector<Vec3f> node, slope;
    std::vector<double> time, born, retired;
    std::vector<std::int64_t> id;
    std::vector<std::int32_t> kind;
};

Points pointsOf(const std::vector<Streak>& streaks)
{
    Points points;
    for (const Streak& streak : streaks) {
        for (const StreakNode& node : streak.path) {
            points.node.emplace_back(node.position.data());
            points.slope.emplace_back(node.slope.data());
            points.time.push_back(node.time);
            points.born.push_back(streak.born);
            points.retired.push_back(streak.retired);
            points.id.push_back(std::int64_t(streak.name));
            points.kind.push_back((streak.slidIn ? kSlidIn : 0) | (streak.isStopped ? kStopped : 0) |
                                  kSource * streak.source);
        }
    }
    return points;
}

template<typename T>
void take(const PointLeaf& leaf, const char* name, std::vector<T>& values)
{
    const openvdb::points::AttributeArray* const array = leaf.attributeSet().getConst(name);
    if (!array || !array->hasValueType<T>())
        throw InputError(fmt::format("its streaks have no attribute '{}' as this run's would", name));
    const AttributeHandle<T> handle(*array);
    for (openvdb::Index i = 0; i < array->size(); ++i)
        values.push_back(handle.get(i));
}

bool isFinite(const Vec3f& vector)
{
    return std::isfinite(vector[0]) && std::isfinite(vector[1]) && std::isfinite(vector[2]);
}

StreakShape shapeOf(const PointDataGrid& grid)
{
    const auto spacing = grid.getMetadata<openvdb::Vec3SMetadata>(kSpacing);
    const auto tail = grid.getMetadata<openvdb::FloatMetadata>(kTail);
    const auto refine = grid.getMetadata<openvdb::Vec3IMetadata>(kRefine);
    if (!spacing || !tail || !refine) throw InputError("its streaks do not tell spacing, tail and refinement");
    StreakShape shape{{}, tail->value(), {}};
    for (int axis = 0; axis < 3; ++axis) {
        shape.spacing[std::size_t(axis)] = spacing->value()[axis];
        shape.refinement.factors[std::size_t(axis)] = refine->value()[axis];
        if (!(shape.spacing[std::size_t(axis)] > 0)) throw InputError("the spacing of its streaks is not above 0");
    }
    shape.refinement.validate();
    return shape;
}

} // namespace

openvdb::GridBase::Ptr streakGrid(const std::vector<Streak>& streaks, const StreakShape& shape)
{
    openvdb::initialize(); // registers the attribute types
    const Points points = pointsOf(streaks);
    const auto transform = openvdb::math::Transform::createLinearTransform(1.0);
    const openvdb::points::PointAttributeVector<Vec3f> positions(points.node);
    const auto index = openvdb::tools::createPointIndexGrid<openvdb::tools::PointIndexGrid>(positions, *transform);
    const auto grid =
        openvdb::points::createPointDataGrid<openvdb::points::NullCodec, PointDataGrid>(*index, positions, *transform);
    grid->setName(kGrid);
    appendValues(*grid, *index, kNode, points.node);
    appendValues(*grid, *index, kSlope, points.slope);
    appendValues(*grid, *index, kTime, points.time);
    appendValues(*grid, *index, kId, points.id);
    appendValues(*grid, *index, kBorn, points.born);
    appendValues(*grid, *index, kRetired, points.retired);
    appendValues(*grid, *index, kKind, points.kind);
    const auto& [x, y, z] = shape.spacing;
    const auto& [nx, ny, nz] = shape.refinement.factors;
    grid->insertMeta(kSpacing, openvdb::Vec3SMetadata(Vec3f(x, y, z)));
    grid->insertMeta(kTail, openvdb::FloatMetadata(shape.tail));
    grid->insertMeta(kRefine, openvdb::Vec3IMetadata(openvdb::Vec3i(nx, ny, nz)));
    return grid;
}

StreakState readStreaks(const VdbFile& file)
{
    const auto grid = file.find<PointDataGrid>(kGrid);
    if (!grid) throw InputError(fmt::format("it has no points '{}'", kGrid));
    Points points;
    for (auto leaf = grid->constTree().cbeginLeaf(); leaf; ++leaf) {
        take(*leaf, kNode, points.node);
        take(*leaf, kSlope, points.slope);
        take(*leaf, kTime, points.time);
        take(*leaf, kId, points.id);
        take(*leaf, kBorn, points.born);
        take(*leaf, kRetired, points.retired);
        take(*leaf, kKind, points.kind);
    }
    std::vector<std::size_t> order(points.id.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return std::tie(points.id[a], points.time[a]) < std::tie(points.id[b], points.time[b]);
    });
    StreakState state{{}, shapeOf(*grid)};
    for (const std::size_t i : order) {
        const auto name = std::uint64_t(points.id[i]);
        const std::int32_t kind = points.kind[i];
        if (!isFinite(points.node[i]) || !isFinite(points.slope[i]) || !std::isfinite(points.time[i]))
            throw InputError("a node of its streaks is no number");
        if (state.streaks.empty() || state.streaks.back().name != name) {
            state.streaks.push_back({.name = name,
                                     .born = points.born[i],
                                     .retired = points.retired[i],
                                     .slidIn = (kind & kSlidIn) != 0,
                                     .isStopped = (kind & kStopped) != 0,
                                     .source = std::uint8_t(kind / kSource)});
        }
        const Vec3f &node = points.node[i], &slope = points.slope[i];
        state.streaks.back().path.push_back(
            {{node[0], node[1], node[2]}, {slope[0], slope[1], slope[2]}, points.time[i]});
    }
    return state;
}

} // namespace vdblic
