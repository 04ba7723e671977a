#include "vdblic/compare/compare.h"
#include "vdblic/compare/report.h"
#include "vdblic/core/errors.h"

#include <openvdb/openvdb.h>
#include <tbb/global_control.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

FloatGrid::Ptr gridOf(const std::vector<std::pair<Coord, float>>& voxels, float background = 0)
{
    auto grid = FloatGrid::create(background);
    for (const auto& [voxel, value] : voxels)
        grid->tree().setValue(voxel, value);
    return grid;
}

/// Random voxels and tiles in several top-level nodes, some inactive.
FloatGrid::Ptr strewn(unsigned seed)
{
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> coordinate(-60, 60);
    std::uniform_real_distribution<float> value(-2, 2);
    auto grid = FloatGrid::create(0.f);
    grid->tree().addTile(1, Coord(40, 40, 40), 1.5f, true);
    for (int i = 0; i < 4000; ++i) {
        const Coord voxel(coordinate(random), coordinate(random), coordinate(random));
        if (i % 7 == 0)
            grid->tree().setValueOff(voxel, value(random));
        else
            grid->tree().setValue(voxel, value(random));
    }
    grid->tree().setValue(Coord(-5000, 7, 9), value(random));
    return grid;
}

std::string json(const GridDifference& grid)
{
    return toJson({"a", "b", {{1, true, true, {"a", "b", {}, {grid}}}}}, {});
}

TEST(CompareGrids, EqualGridsAreTheSameWithFiguresOfZero)
{
    const auto a = strewn(1);
    const GridDifference result = compareGrids(*a, *a->deepCopy());
    EXPECT_EQ(result.verdict(), Verdict::kSame);
    ASSERT_TRUE(result.values);
    EXPECT_EQ(result.values->compared, a->activeVoxelCount());
    EXPECT_EQ(result.values->failing, 0u);
    EXPECT_EQ(result.values->error.max, 0.);
    EXPECT_TRUE(std::isinf(result.values->psnr));
    EXPECT_GT(result.values->peak, 1.);
    EXPECT_FALSE(result.values->first || result.values->worst);
}

TEST(CompareGrids, FiguresEqualALiteralReference)
{
    const auto a = strewn(1), b = strewn(2);
    const double fail = 0.25, relative = 0.125;
    std::set<Coord> voxels;
    for (const auto& grid : {a, b}) {
        auto copy = grid->deepCopy();
        copy->tree().voxelizeActiveTiles();
        for (auto it = copy->cbeginValueOn(); it; ++it)
            voxels.insert(it.getCoord());
    }
    double sum = 0, squares = 0, max = 0, peak = 0, maxRelative = 0;
    std::uint64_t over = 0, failing = 0, onlyA = 0, onlyB = 0;
    std::optional<Coord> first, worst;
    for (const Coord& voxel : voxels) { // ordered by (x, y, z)
        const double x = a->tree().getValue(voxel), y = b->tree().getValue(voxel), error = std::abs(x - y);
        const bool onA = a->tree().isValueOn(voxel), onB = b->tree().isValueOn(voxel);
        const double magnitude = std::max(std::abs(x), std::abs(y));
        sum += error;
        squares += error * error;
        peak = std::max(peak, magnitude);
        if (error > 0) maxRelative = std::max(maxRelative, error / magnitude);
        if (error > max) worst = voxel;
        max = std::max(max, error);
        const bool isOver = error > std::max(fail, relative * magnitude);
        over += isOver;
        failing += isOver || onA != onB;
        onlyA += onA && !onB;
        onlyB += onB && !onA;
        if (!first && (isOver || onA != onB)) first = voxel;
    }
    const auto count = double(voxels.size());
    const ValueDifference values = *compareGrids(*a, *b, {.fail = fail, .relative = relative}).values;
    EXPECT_EQ(values.compared, voxels.size());
    EXPECT_NEAR(values.error.mean, sum / count, 1e-12);
    EXPECT_NEAR(values.error.rms, std::sqrt(squares / count), 1e-12);
    EXPECT_EQ(values.error.max, max);
    EXPECT_EQ(values.peak, peak);
    EXPECT_EQ(values.maxRelative, maxRelative);
    EXPECT_NEAR(values.psnr, 20 * std::log10(peak / std::sqrt(squares / count)), 1e-9);
    EXPECT_EQ(values.overFail, over);
    EXPECT_EQ(values.failing, failing);
    EXPECT_EQ(values.onlyInA, onlyA);
    EXPECT_EQ(values.onlyInB, onlyB);
    ASSERT_TRUE(values.first && values.worst);
    EXPECT_EQ(values.first->index, (std::array<std::int64_t, 3>{first->x(), first->y(), first->z()}));
    EXPECT_EQ(values.worst->index, (std::array<std::int64_t, 3>{worst->x(), worst->y(), worst->z()}));
}

TEST(CompareGrids, BitsDependNeitherOnThreadsNorOnTheSide)
{
    const auto a = strewn(3), b = strewn(4);
    std::string one, many;
    {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
        one = json(compareGrids(*a, *b));
    }
    {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
        many = json(compareGrids(*a, *b));
    }
    EXPECT_EQ(one, many);
    EXPECT_EQ(compareGrids(*a, *b).values->error.rms, compareGrids(*b, *a).values->error.rms);
}

TEST(CompareGrids, ATileAndEqualVoxelsAreTheSame)
{
    for (const openvdb::Index level : {1u, 2u}) {
        auto a = FloatGrid::create(0.f);
        a->tree().addTile(level, Coord(128, 0, -128), 2.f, true);
        auto b = a->deepCopy();
        b->tree().voxelizeActiveTiles();
        ASSERT_NE(a->tree().leafCount(), b->tree().leafCount());
        const GridDifference same = compareGrids(*a, *b);
        EXPECT_EQ(same.verdict(), Verdict::kSame) << json(same);
        EXPECT_EQ(same.values->compared, a->activeVoxelCount());

        // One different voxel is found, from either side.
        b->tree().setValue(Coord(130, 1, -121), 2.5f);
        const ValueDifference there = *compareGrids(*a, *b).values, back = *compareGrids(*b, *a).values;
        EXPECT_EQ(there.failing, 1u);
        EXPECT_EQ(back.failing, 1u);
        EXPECT_EQ(there.first->index, (std::array<std::int64_t, 3>{130, 1, -121}));
        EXPECT_EQ(there.first->a, "2");
        EXPECT_EQ(there.first->b, "2.5");
    }
}

TEST(CompareGrids, TilesCountAsManyVoxels)
{
    auto a = FloatGrid::create(0.f), b = FloatGrid::create(0.f);
    a->tree().addTile(2, Coord(0), 1.f, true);
    b->tree().addTile(2, Coord(0), 1.5f, true);
    const ValueDifference tiles = *compareGrids(*a, *b).values;
    a->tree().voxelizeActiveTiles();
    const ValueDifference mixed = *compareGrids(*a, *b).values;
    EXPECT_EQ(tiles.compared, 128u * 128 * 128);
    EXPECT_EQ(tiles.failing, tiles.compared);
    EXPECT_EQ(tiles.error.mean, 0.5);
    EXPECT_EQ(tiles.error.rms, mixed.error.rms);
    EXPECT_EQ(tiles.first->index, mixed.first->index);
    EXPECT_EQ(tiles.worst->index, mixed.worst->index);
    EXPECT_EQ(tiles.maxRelative, mixed.maxRelative);
}

TEST(CompareGrids, NotANumberAndInfinitiesEqualThemselvesOnly)
{
    const Coord at(3, 4, 5), other(3, 4, 6);
    const auto failing = [&](float x, float y) {
        // A finite neighbour differs too, so that the leaves differ in their bytes.
        const auto values =
            *compareGrids(*gridOf({{at, x}, {other, 1.f}}), *gridOf({{at, y}, {other, 1.25f}}), {.fail = 1e30}).values;
        EXPECT_EQ(values.notFinite, values.failing);
        EXPECT_EQ(values.error.max, values.failing > 0 ? double(kInf) : 0.25);
        if (values.failing > 0) {
            EXPECT_EQ(values.worst->index[2], 5);
        }
        EXPECT_FALSE(std::isnan(values.error.mean) || std::isnan(values.error.rms) || std::isnan(values.peak));
        return values.failing;
    };
    EXPECT_EQ(failing(kNan, kNan), 0u);
    EXPECT_EQ(failing(kNan, -kNan), 0u);
    EXPECT_EQ(failing(kInf, kInf), 0u);
    EXPECT_EQ(failing(-kInf, -kInf), 0u);
    EXPECT_EQ(failing(kNan, 0.f), 1u);
    EXPECT_EQ(failing(2.f, kNan), 1u);
    EXPECT_EQ(failing(kInf, 2.f), 1u);
    EXPECT_EQ(failing(kInf, -kInf), 1u);
    EXPECT_EQ(failing(kInf, kNan), 1u);
}

TEST(CompareGrids, NotANumberInATileOrABackground)
{
    auto a = FloatGrid::create(kNan), b = FloatGrid::create(kNan);
    a->tree().addTile(1, Coord(0), kNan, true);
    b->tree().addTile(1, Coord(0), kNan, true);
    EXPECT_EQ(compareGrids(*a, *b).verdict(), Verdict::kSame);
    b->tree().addTile(1, Coord(0), 1.f, true);
    EXPECT_EQ(compareGrids(*a, *b).values->notFinite, 512u);
    auto c = FloatGrid::create(0.f);
    EXPECT_TRUE(compareGrids(*a, *c).background);
}

TEST(CompareGrids, TopologyIsADifferenceWhateverTheValues)
{
    auto a = gridOf({{Coord(0), 1.f}, {Coord(1), 1.f}}), b = gridOf({{Coord(0), 1.f}});
    b->tree().setValueOff(Coord(1), 1.f); // the same value, not active
    const GridDifference result = compareGrids(*a, *b, {.fail = 100});
    EXPECT_EQ(result.verdict(), Verdict::kDiffers);
    EXPECT_EQ(result.values->onlyInA, 1u);
    EXPECT_EQ(result.values->onlyInB, 0u);
    EXPECT_EQ(result.values->overFail, 0u);
    EXPECT_TRUE(result.values->first->activeInA);
    EXPECT_FALSE(result.values->first->activeInB);
    EXPECT_EQ(compareGrids(*b, *a).values->onlyInB, 1u);
}

TEST(CompareGrids, InactiveValuesAreComparedWhenAsked)
{
    auto a = gridOf({{Coord(0), 1.f}}), b = gridOf({{Coord(0), 1.f}});
    a->tree().setValueOff(Coord(5, 0, 0), 3.f);
    EXPECT_EQ(compareGrids(*a, *b).verdict(), Verdict::kSame);
    const GridDifference inactive = compareGrids(*a, *b, {.inactive = true});
    EXPECT_EQ(inactive.verdict(), Verdict::kDiffers);
    EXPECT_EQ(inactive.values->compared, 2u); // not the background around them
    EXPECT_EQ(inactive.values->error.max, 3.);
    // An inactive tile and inactive voxels of its value are the same.
    auto c = FloatGrid::create(0.f), d = FloatGrid::create(0.f);
    c->tree().addTile(1, Coord(0), 7.f, false);
    for (int n = 0; n < 512; ++n)
        d->tree().setValueOff(Coord(n >> 6, n >> 3 & 7, n & 7), 7.f);
    const GridDifference same = compareGrids(*c, *d, {.inactive = true});
    EXPECT_EQ(same.verdict(), Verdict::kSame);
    EXPECT_EQ(same.values->compared, 512u);
}

TEST(CompareGrids, ThresholdsActAsIdiffs)
{
    std::vector<std::pair<Coord, float>> voxels;
    voxels.reserve(100);
    for (int i = 0; i < 100; ++i)
        voxels.emplace_back(Coord(i, 0, 0), 1.f);
    const auto a = gridOf(voxels);
    for (int i = 0; i < 5; ++i)
        voxels[std::size_t(i)].second = 1.5f; // 5 % are off by 0.5, a third of the larger
    const auto b = gridOf(voxels);
    const auto verdict = [&](const CompareParams& params) { return compareGrids(*a, *b, params).verdict(); };

    EXPECT_EQ(verdict({}), Verdict::kDiffers);
    EXPECT_EQ(verdict({.fail = 0.5}), Verdict::kSame); // up to, not below
    EXPECT_EQ(verdict({.fail = 0.49}), Verdict::kDiffers);
    EXPECT_EQ(verdict({.relative = 0.34}), Verdict::kSame);
    EXPECT_EQ(verdict({.relative = 0.33}), Verdict::kDiffers);
    EXPECT_EQ(verdict({.fail = 0.5, .relative = 0.001}), Verdict::kSame); // the larger tolerance applies
    EXPECT_EQ(verdict({.fail = 0.1, .failPercent = 5}), Verdict::kSame);
    EXPECT_EQ(verdict({.fail = 0.1, .failPercent = 4.9}), Verdict::kDiffers);
    EXPECT_EQ(compareGrids(*a, *b).values->failingPercent(), 5.);
}

TEST(CompareGrids, ToleranceThatIsNoNumberIsRefused)
{
    const auto a = gridOf({});
    for (const double bad : {double(kNan), -1., double(kInf)}) {
        EXPECT_THROW((void)compareGrids(*a, *a, {.fail = bad}), ParameterError);
        EXPECT_THROW((void)compareGrids(*a, *a, {.relative = bad}), ParameterError);
        EXPECT_THROW((void)compareGrids(*a, *a, {.failPercent = bad}), ParameterError);
    }
    EXPECT_THROW((void)compareGrids(*a, *a, {.failPercent = 101}), ParameterError);
}

TEST(CompareGrids, PlacesFollowARotatedTransform)
{
    auto a = gridOf({{Coord(2, 0, 0), 1.f}, {Coord(0, 20, 0), 1.f}}), b = a->deepCopy();
    // A quarter turn about z takes +x to +y; then voxels of 0.5 and a shift.
    openvdb::Mat4d matrix = openvdb::Mat4d::identity();
    matrix.setToRotation(openvdb::Vec3d(0, 0, 1), openvdb::math::pi<double>() / 2);
    matrix.postScale(openvdb::Vec3d(0.5));
    matrix.postTranslate(openvdb::Vec3d(10, 0, 1));
    a->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    b->setTransform(a->transform().copy());
    b->tree().setValue(Coord(2, 0, 0), 3.f);
    b->tree().setValue(Coord(0, 20, 0), 2.f);
    const ValueDifference values = *compareGrids(*a, *b).values;
    EXPECT_EQ(values.first->index, (std::array<std::int64_t, 3>{0, 20, 0}));
    EXPECT_EQ(values.worst->index, (std::array<std::int64_t, 3>{2, 0, 0}));
    EXPECT_EQ(values.worst->error, 2.);
    const std::array<double, 3> first{std::abs(values.first->world[0]), values.first->world[1], values.first->world[2]};
    EXPECT_NEAR(first[0], 0, 1e-12); // 10 − 20/2
    EXPECT_NEAR(first[1], 0, 1e-12);
    EXPECT_NEAR(values.worst->world[0], 10, 1e-12);
    EXPECT_NEAR(values.worst->world[1], 1, 1e-12);
    EXPECT_NEAR(values.worst->world[2], 1, 1e-12);
}

TEST(CompareGrids, TransformsDifferByWhatTheyDoToTheVoxels)
{
    auto a = gridOf({{Coord(0), 1.f}, {Coord(100), 1.f}}), b = a->deepCopy();
    a->setTransform(openvdb::math::Transform::createLinearTransform(0.1));
    b->setTransform(openvdb::math::Transform::createLinearTransform(0.2));
    const GridDifference scaled = compareGrids(*a, *b);
    EXPECT_EQ(scaled.verdict(), Verdict::kDiffers);
    ASSERT_TRUE(scaled.transform);
    EXPECT_GT(scaled.transform->shift, 100.);
    EXPECT_EQ(scaled.values->failing, 0u);

    b->setTransform(openvdb::math::Transform::createLinearTransform(double(0.1f))); // single precision's 0.1
    EXPECT_EQ(compareGrids(*a, *b).verdict(), Verdict::kSame);
    EXPECT_TRUE(compareGrids(*a, *b, {.transformTolerance = 0}).transform);

    // The same placement by another kind of map.
    openvdb::Mat4d matrix = openvdb::Mat4d::identity();
    matrix.setToScale(openvdb::Vec3d(0.1));
    b->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    EXPECT_EQ(compareGrids(*a, *b).verdict(), Verdict::kSame);

    b->transform().postTranslate(openvdb::Vec3d(0.05, 0, 0));
    EXPECT_NEAR(compareGrids(*a, *b).transform->shift, 0.5, 1e-9);
}

TEST(CompareGrids, MetadataBackgroundAndTypeAreNamed)
{
    auto a = gridOf({}), b = gridOf({}, 1.f);
    a->setGridClass(openvdb::GRID_FOG_VOLUME);
    a->insertMeta("n", openvdb::Int32Metadata(3));
    b->insertMeta("n", openvdb::DoubleMetadata(3)); // the same number
    a->insertMeta("creator", openvdb::StringMetadata("x"));
    b->insertMeta("file_bbox_min", openvdb::Vec3IMetadata(openvdb::Vec3i(1)));
    b->insertMeta("file_base_resolution", openvdb::Vec3IMetadata(openvdb::Vec3i(1)));
    const GridDifference result = compareGrids(*a, *b);
    ASSERT_EQ(result.metadata.size(), 2u);
    EXPECT_EQ(result.metadata[0].key, "class");
    EXPECT_EQ(result.metadata[0].a, "fog volume");
    EXPECT_FALSE(result.metadata[0].b);
    EXPECT_EQ(result.metadata[1].key, "file_base_resolution");
    ASSERT_TRUE(result.background);
    EXPECT_EQ(result.background->b, "1");
    EXPECT_TRUE(compareGrids(*a, *b, {.ignoredMetadata = {"cl*", "creator", "file_*"}}).metadata.empty());

    const GridDifference types = compareGrids(*a, *openvdb::DoubleGrid::create());
    EXPECT_EQ(types.typeA, "float");
    EXPECT_EQ(types.typeB, "double");
    EXPECT_FALSE(types.values);
    EXPECT_EQ(types.verdict(), Verdict::kDiffers);
}

TEST(CompareGrids, WhatCannotBeComparedIsAnInputError)
{
    const auto grid = openvdb::tools::PointIndexGrid::create();
    EXPECT_THROW((void)compareGrids(*grid, *grid), InputError);
}

TEST(CompareGrids, EmptyGridsAreTheSame)
{
    const GridDifference result = compareGrids(*gridOf({}), *gridOf({}));
    EXPECT_EQ(result.verdict(), Verdict::kSame);
    EXPECT_EQ(result.values->compared, 0u);
    EXPECT_EQ(result.values->error.mean, 0.);
    EXPECT_EQ(result.values->failingPercent(), 0.);
}

} // namespace
} // namespace vdblic
