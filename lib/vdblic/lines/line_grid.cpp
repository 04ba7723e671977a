#include "vdblic/lines/line_grid.h"

#include "vdblic/core/errors.h"
#include "vdblic/lines/point_values.h"

#include <fmt/format.h>
#include <openvdb/points/PointConversion.h>
#include <openvdb/points/PointDataGrid.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Vec3f;
using openvdb::points::PointDataGrid;
using openvdb::points::PointDataTree;
using openvdb::tools::PointIndexGrid;
using PointLeaf = PointDataTree::LeafNodeType;

constexpr const char *kPosition = "P", *kId = "id", *kOrder = "order", *kRadius = "pscale", *kOpacity = "Alpha";
constexpr const char* kSource = "source";

/// Codecs: a float as 16 bits; a float in [0, 1] as 8 bits.
using HalfCodec = openvdb::points::TruncateCodec;
using UnitCodec = openvdb::points::FixedPointCodec<true, openvdb::points::UnitRange>;

/// Append a scalar as halfs, or as floats where its largest magnitude is outside the range of texture files.
void appendScalar(PointDataGrid& grid, const PointIndexGrid& index, const std::string& name,
                  const std::vector<float>& values)
{
    constexpr float kLeast = 1.0f / 16, kMost = 65504;
    float largest = 0;
    for (const float value : values)
        largest = std::fmax(largest, std::abs(value)); // passes over NaN
    const bool fits = largest == 0 || (largest >= kLeast && largest <= kMost);
    fits ? appendValues<float, HalfCodec>(grid, index, name, values) : appendValues(grid, index, name, values);
}

/// The values of an attribute at the points of a leaf. @throws InputError
template<typename T>
openvdb::points::AttributeHandle<T> attributeOf(const PointLeaf& leaf, const std::string& name)
{
    const openvdb::points::AttributeArray* const array = leaf.attributeSet().getConst(name);
    if (!array || !array->hasValueType<T>())
        throw InputError(
            fmt::format("its lines have no attribute '{}' of type {}", name, openvdb::typeNameAsString<T>()));
    if (array->size() != openvdb::Index(leaf.getLastValue()))
        throw InputError(fmt::format("its lines have {} values of '{}' for {} points", array->size(), name,
                                     openvdb::Index(leaf.getLastValue())));
    return openvdb::points::AttributeHandle<T>(*array);
}

float finite(float value, const std::string& name)
{
    if (!std::isfinite(value)) throw InputError(fmt::format("'{}' of its lines has the value {}", name, value));
    return value;
}

/// All points of a grid in the order of the file.
struct StoredPoints {
    std::vector<std::int32_t> id, order, source;
    Lines values; // without its lines
};

/// Check a leaf's properties that OpenVDB takes for granted. @throws InputError
void check(const PointLeaf& leaf)
{
    const openvdb::points::AttributeSet& attributes = leaf.attributeSet();
    const auto& places = attributes.descriptor().map();
    const bool isThere =
        std::all_of(places.begin(), places.end(), [&](const auto& place) { return place.second < attributes.size(); });
    if (!isThere) throw InputError("its lines lack an attribute that they name");
    try {
        leaf.validateOffsets();
    } catch (const openvdb::ValueError& error) {
        throw InputError(fmt::format("its lines are damaged ({})", error.what()));
    }
}

void read(const PointLeaf& leaf, StoredPoints& points)
{
    const auto position = attributeOf<Vec3f>(leaf, kPosition);
    const auto id = attributeOf<std::int32_t>(leaf, kId);
    const auto order = attributeOf<std::int32_t>(leaf, kOrder);
    const auto radius = attributeOf<float>(leaf, kRadius), opacity = attributeOf<float>(leaf, kOpacity);
    const auto age = attributeOf<float>(leaf, kLineAge);
    for (auto point = leaf.beginIndexAll(); point; ++point) {
        const Vec3f place = position.get(*point) + Vec3f(point.getCoord().asVec3s());
        for (int axis = 0; axis < 3; ++axis)
            (void)finite(place[axis], kPosition);
        points.values.positions.push_back(place);
        points.id.push_back(id.get(*point));
        points.order.push_back(order.get(*point));
        points.values.radii.push_back(finite(radius.get(*point), kRadius));
        points.values.opacities.push_back(finite(opacity.get(*point), kOpacity));
        points.values.ages.push_back(finite(age.get(*point), kLineAge));
    }
    if (leaf.hasAttribute(kSource)) {
        const auto source = attributeOf<std::int32_t>(leaf, kSource);
        for (auto point = leaf.beginIndexAll(); point; ++point)
            points.source.push_back(source.get(*point));
    }
    for (Lines::Scalar& scalar : points.values.scalars) {
        const auto values = attributeOf<float>(leaf, scalar.name);
        for (auto point = leaf.beginIndexAll(); point; ++point)
            scalar.values.push_back(values.get(*point));
    }
}

std::vector<Lines::Scalar> scalarsOf(const PointLeaf& leaf)
{
    std::vector<Lines::Scalar> scalars;
    for (const auto& [name, at] : leaf.attributeSet().descriptor().map()) {
        const bool isOwn = std::find(kLineAttributes.begin(), kLineAttributes.end(), name) != kLineAttributes.end();
        if (!isOwn && leaf.attributeSet().getConst(at)->hasValueType<float>()) scalars.push_back({name, {}});
    }
    return scalars;
}

/// Values in an order: the result's i-th one is at order[i].
template<typename T>
std::vector<T> ordered(const std::vector<std::uint32_t>& order, const std::vector<T>& values)
{
    std::vector<T> result(order.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, order.size()), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i)
            result[i] = values[order[i]];
    });
    return result;
}

/// Number the points of an index in the order of its leaves, so that those of a leaf are near in memory.
/// @return their numbers so far, in the new order
std::vector<std::uint32_t> renumbered(PointIndexGrid& index)
{
    std::vector<std::uint32_t> order;
    for (auto leaf = index.tree().beginLeaf(); leaf; ++leaf) {
        for (auto& number : leaf->indices()) {
            order.push_back(number);
            number = std::uint32_t(order.size() - 1);
        }
    }
    return order;
}

} // namespace

openvdb::GridBase::Ptr lineGrid(const Lines& lines, const openvdb::math::Transform& transform,
                                std::span<const openvdb::FloatGrid::Ptr> scalars)
{
    openvdb::initialize(); // registers the attribute types
    std::vector<std::int32_t> ids(lines.pointCount()), orders(lines.pointCount()), sources(lines.pointCount());
    bool hasSources = false;
    for (const Lines::Line& line : lines.lines) {
        hasSources = hasSources || line.source != 0;
        for (std::uint32_t i = line.begin; i < line.end; ++i) {
            ids[i] = line.id;
            sources[i] = line.source;
            orders[i] = std::int32_t(i - line.begin);
        }
    }
    using PositionCodec = openvdb::points::FixedPointCodec<false>;
    using Positions = openvdb::points::PointAttributeVector<Vec3f>;
    const auto voxels = openvdb::math::Transform::createLinearTransform(1.0); // positions are in index space
    const auto index = openvdb::tools::createPointIndexGrid<PointIndexGrid>(Positions(lines.positions), *voxels);
    const std::vector<std::uint32_t> order = renumbered(*index);
    const std::vector<Vec3f> positions = ordered(order, lines.positions);
    const auto grid =
        openvdb::points::createPointDataGrid<PositionCodec, PointDataGrid>(*index, Positions(positions), *voxels);
    grid->setTransform(transform.copy());
    grid->setName(kLineGrid);
    appendValues(*grid, *index, kId, ordered(order, ids));
    appendValues(*grid, *index, kOrder, ordered(order, orders));
    appendScalar(*grid, *index, kRadius, ordered(order, lines.radii));
    appendValues<float, UnitCodec>(*grid, *index, kOpacity, ordered(order, lines.opacities));
    appendValues(*grid, *index, kLineAge, ordered(order, lines.ages));
    if (hasSources) appendValues(*grid, *index, kSource, ordered(order, sources));
    for (const Lines::Scalar& scalar : lines.scalars)
        appendScalar(*grid, *index, scalar.name, ordered(order, scalar.values));
    for (const openvdb::FloatGrid::Ptr& scalar : scalars)
        appendScalar(*grid, *index, scalar->getName(), valuesAt(*scalar, positions, transform));
    return grid;
}

Lines linesOf(const openvdb::GridBase& base)
{
    const auto* const grid = dynamic_cast<const PointDataGrid*>(&base);
    if (!grid) throw InputError(fmt::format("'{}' holds no points", base.getName()));
    StoredPoints points;
    for (auto leaf = grid->constTree().cbeginLeaf(); leaf; ++leaf)
        check(*leaf);
    if (const auto first = grid->constTree().cbeginLeaf()) points.values.scalars = scalarsOf(*first);
    for (auto leaf = grid->constTree().cbeginLeaf(); leaf; ++leaf)
        read(*leaf, points);
    std::vector<std::uint32_t> order(points.id.size());
    for (std::uint32_t i = 0; i < order.size(); ++i)
        order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::pair(points.id[a], points.order[a]) < std::pair(points.id[b], points.order[b]);
    });
    Lines& lines = points.values;
    for (std::uint32_t i = 0; i < order.size(); ++i) {
        const std::int32_t id = points.id[order[i]];
        if (lines.lines.empty() || lines.lines.back().id != id) {
            const std::int32_t source = points.source.empty() ? 0 : points.source[order[i]];
            if (source < 0 || source > std::numeric_limits<std::uint8_t>::max())
                throw InputError(fmt::format("'{}' of its lines has the value {}", kSource, source));
            lines.lines.push_back({id, i, i, std::uint8_t(source)});
        }
        Lines::Line& line = lines.lines.back();
        if (points.order[order[i]] != std::int32_t(i - line.begin))
            throw InputError(fmt::format("point {} of its line {} is missing or twice there", i - line.begin, id));
        line.end = i + 1;
    }
    lines.positions = ordered(order, lines.positions);
    lines.radii = ordered(order, lines.radii);
    lines.opacities = ordered(order, lines.opacities);
    lines.ages = ordered(order, lines.ages);
    for (Lines::Scalar& scalar : lines.scalars)
        scalar.values = ordered(order, scalar.values);
    return std::move(lines);
}

std::vector<float> valuesAt(const openvdb::FloatGrid& scalar, std::span<const openvdb::Vec3f> points,
                            const openvdb::math::Transform& transform)
{
    std::vector<float> values(points.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size()), [&](const auto& range) {
        auto accessor = scalar.getConstUnsafeAccessor();
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const openvdb::Vec3d place = scalar.worldToIndex(transform.indexToWorld(openvdb::Vec3d(points[i])));
            const openvdb::Coord low = openvdb::Coord::floor(place);
            const openvdb::Vec3d share = place - low.asVec3d();
            double sum = 0, weights = 0;
            for (int corner = 0; corner < 8; ++corner) {
                const std::array<int, 3> side = {corner & 1, corner >> 1 & 1, corner >> 2};
                double weight = 1;
                for (int axis = 0; axis < 3; ++axis)
                    weight *= side[std::size_t(axis)] == 0 ? 1 - share[axis] : share[axis];
                float value = 0;
                if (!accessor.probeValue(low.offsetBy(side[0], side[1], side[2]), value) || !std::isfinite(value))
                    continue;
                sum += weight * double(value);
                weights += weight;
            }
            values[i] = weights > 0 ? float(sum / weights) : std::numeric_limits<float>::quiet_NaN();
        }
    });
    return values;
}

} // namespace vdblic
