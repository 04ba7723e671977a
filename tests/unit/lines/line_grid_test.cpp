#include "vdblic/core/errors.h"
#include "vdblic/lines/line_grid.h"

#include <gtest/gtest.h>
#include <openvdb/points/PointAttribute.h>
#include <openvdb/points/PointDataGrid.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace vdblic {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// Three lines of 5, 2 and 2000 points, the last one through many leaves.
Lines someLines()
{
    Lines lines;
    lines.scalars = {{"q", {}}, {"large", {}}};
    const auto add = [&](std::int32_t id, std::uint32_t count, std::uint8_t source) {
        const auto begin = std::uint32_t(lines.pointCount());
        for (std::uint32_t i = 0; i < count; ++i) {
            lines.positions.emplace_back(float(i) * 0.37f - 20, 3 * std::sin(float(i) * 0.1f), float(id % 7));
            lines.radii.push_back(0.25f + float(i));
            lines.opacities.push_back(float(i + 1) / float(count));
            lines.ages.push_back(float(count - 1 - i) / 64);
            lines.scalars[0].values.push_back(i == 1 ? kNone : float(i) / 4);
            lines.scalars[1].values.push_back(1e5f + float(i));
        }
        lines.lines.push_back({id, begin, begin + count, source});
    };
    add(-17, 5, 2);
    add(3, 2, 0);
    add(2000000000, 2000, 1);
    return lines;
}

const auto kTransform = openvdb::math::Transform::createLinearTransform(0.5);

/// Give all points another value. @return the grid
template<typename T>
openvdb::GridBase::Ptr withValue(const std::string& attribute, const T& value)
{
    const openvdb::GridBase::Ptr grid = lineGrid(someLines(), *kTransform);
    auto& tree = openvdb::gridPtrCast<openvdb::points::PointDataGrid>(grid)->tree();
    for (auto leaf = tree.beginLeaf(); leaf; ++leaf) {
        const auto values = openvdb::points::AttributeWriteHandle<T>::create(leaf->attributeArray(attribute));
        for (openvdb::Index i = 0; i < leaf->pointCount(); ++i)
            values->set(i, value);
    }
    return grid;
}

void expectRefused(const openvdb::GridBase& grid, const std::string& attribute)
{
    try {
        (void)linesOf(grid);
        FAIL() << attribute;
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find(attribute), std::string::npos) << error.what();
    }
}

TEST(LineGrid, KeepsLinesButForItsPrecision)
{
    const Lines lines = someLines();
    const Lines found = linesOf(*lineGrid(lines, *kTransform));
    ASSERT_EQ(found.lines.size(), 3);
    ASSERT_EQ(found.pointCount(), lines.pointCount());
    ASSERT_EQ(found.scalars.size(), 2);
    const std::size_t q = found.scalars[0].name == "q" ? 0 : 1;
    for (std::size_t line = 0; line < 3; ++line) {
        EXPECT_EQ(found.lines[line].id, lines.lines[line].id);
        EXPECT_EQ(found.lines[line].begin, lines.lines[line].begin);
        EXPECT_EQ(found.lines[line].end, lines.lines[line].end);
        EXPECT_EQ(found.lines[line].source, lines.lines[line].source);
    }
    float farthest = 0;
    for (std::size_t i = 0; i < lines.pointCount(); ++i) {
        farthest = std::max(farthest, (found.positions[i] - lines.positions[i]).length());
        EXPECT_NEAR(found.radii[i], lines.radii[i], 1e-3f * std::abs(lines.radii[i]));
        EXPECT_TRUE(std::abs(found.opacities[i] - lines.opacities[i]) <= 1.0f / 255 + 1e-6f);
        EXPECT_EQ(found.ages[i], lines.ages[i]);
        const float value = lines.scalars[0].values[i];
        EXPECT_TRUE((std::isnan(value) ? std::isnan(found.scalars[q].values[i]) : found.scalars[q].values[i] == value));
        EXPECT_TRUE(found.scalars[1 - q].values[i] == lines.scalars[1].values[i]); // more than a half can be
    }
    EXPECT_TRUE(farthest < 3e-5f); // 16 bits a coordinate
    EXPECT_TRUE(farthest > 0);
}

/// Such as Q of the atmosphere in SI units, which as halfs were all 0.
TEST(LineGrid, KeepsScalarsThatAreTooSmallForHalfs)
{
    Lines lines = someLines();
    for (float& value : lines.scalars[1].values)
        value *= 1e-14f;
    lines.scalars[1].values[7] = kNone;
    const Lines found = linesOf(*lineGrid(lines, *kTransform));
    const std::size_t tiny = found.scalars[0].name == "large" ? 0 : 1;
    for (std::size_t i = 0; i < lines.pointCount(); ++i)
        EXPECT_TRUE(i == 7 || found.scalars[tiny].values[i] == lines.scalars[1].values[i]) << i;
}

TEST(LineGrid, HasTheValuesOfAScalarAtItsPoints)
{
    const Lines lines = someLines();
    const auto heat = openvdb::FloatGrid::create();
    heat->setName("heat");
    for (openvdb::CoordBBox::Iterator<true> voxel({{-30, -5, -5}, {200, 5, 5}}); voxel; ++voxel)
        heat->tree().setValue(*voxel, float((*voxel)[0] % 16) + 16 * float((*voxel)[1]));
    const std::vector<openvdb::FloatGrid::Ptr> scalars = {heat};
    const Lines found = linesOf(*lineGrid(lines, *kTransform, scalars));
    const auto values = std::ranges::find(found.scalars, "heat", &Lines::Scalar::name);
    ASSERT_NE(values, found.scalars.end());
    const std::vector<float> expected = valuesAt(*heat, lines.positions, *kTransform);
    for (std::size_t i = 0; i < expected.size(); ++i) {
        if (std::isnan(expected[i]))
            EXPECT_TRUE(std::isnan(values->values[i])) << i;
        else
            EXPECT_NEAR(values->values[i], expected[i], 0.07f) << i; // a half
    }
}

TEST(LineGrid, MayBeEmpty)
{
    const openvdb::GridBase::Ptr grid = lineGrid({}, *kTransform);
    EXPECT_TRUE(grid->empty());
    EXPECT_TRUE(linesOf(*grid).lines.empty());
    EXPECT_THROW((void)linesOf(openvdb::FloatGrid()), InputError);
}

TEST(LineGrid, IsRefusedIfDamaged)
{
    EXPECT_NO_THROW((void)linesOf(*withValue<float>("q", kNone)));
    expectRefused(*withValue<float>("age", kNone), "age");
    expectRefused(*withValue<std::int32_t>("order", 7), "missing or twice");
    expectRefused(*withValue<std::int32_t>("source", 300), "source");
    const openvdb::GridBase::Ptr disordered = lineGrid(someLines(), *kTransform);
    openvdb::gridPtrCast<openvdb::points::PointDataGrid>(disordered)->tree().beginLeaf()->setOffsetOnly(511, 0);
    expectRefused(*disordered, "damaged");
    for (const char* attribute : {"id", "order", "pscale", "Alpha", "age"}) {
        const openvdb::GridBase::Ptr grid = lineGrid(someLines(), *kTransform);
        openvdb::points::dropAttribute(openvdb::gridPtrCast<openvdb::points::PointDataGrid>(grid)->tree(), attribute);
        expectRefused(*grid, attribute);
    }
}

TEST(LineGrid, InterpolatesScalars)
{
    const openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create();
    grid->setTransform(openvdb::math::Transform::createLinearTransform(2.0));
    grid->fill(openvdb::CoordBBox({0, 0, 0}, {3, 3, 3}), 0.0f);
    for (auto voxel = grid->beginValueOn(); voxel; ++voxel)
        voxel.setValue(float(voxel.getCoord().x()) * 10);
    grid->tree().setValue({2, 0, 0}, kNone);
    // Points have voxels of half the size of the grid's.
    const std::vector<openvdb::Vec3f> points = {{6, 12, 12}, {5, 12, 12}, {5, 0, 0},
                                                {-3, 0, 0},  {-4, 0, 0},  {1e9f, 0, 0}};
    const std::vector<float> values = valuesAt(*grid, points, *openvdb::math::Transform::createLinearTransform(0.5));
    EXPECT_FLOAT_EQ(values[0], 15);
    EXPECT_FLOAT_EQ(values[1], 12.5);
    EXPECT_FLOAT_EQ(values[2], 10); // the neighbour is not a number
    EXPECT_FLOAT_EQ(values[3], 0);  // only one neighbour has a value
    EXPECT_TRUE(std::isnan(values[4]));
    EXPECT_TRUE(std::isnan(values[5]));
}

} // namespace
} // namespace vdblic
