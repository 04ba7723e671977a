#include "vdblic/compare/compare.h"

#include <openvdb/openvdb.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace vdblic {
namespace {

using openvdb::Coord;

template<typename T>
struct Example;
template<>
struct Example<openvdb::FloatGrid> {
    static float value(int n) { return float(n) * 0.5f; }
};
template<>
struct Example<openvdb::DoubleGrid> {
    static double value(int n) { return n * 0.5; }
};
template<>
struct Example<openvdb::Int32Grid> {
    static std::int32_t value(int n) { return n; }
};
template<>
struct Example<openvdb::Int64Grid> {
    static std::int64_t value(int n) { return n; }
};
template<>
struct Example<openvdb::BoolGrid> {
    static bool value(int n) { return n > 0; }
};
template<>
struct Example<openvdb::Vec3SGrid> {
    static openvdb::Vec3f value(int n) { return {float(n), 1.f, 2.f}; }
};
template<>
struct Example<openvdb::Vec3DGrid> {
    static openvdb::Vec3d value(int n) { return {double(n), 1., 2.}; }
};
template<>
struct Example<openvdb::Vec3IGrid> {
    static openvdb::Vec3i value(int n) { return {n, 1, 2}; }
};

template<typename GridT>
class CompareTypes : public testing::Test {
};
using Types = testing::Types<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid, openvdb::Int64Grid,
                             openvdb::BoolGrid, openvdb::Vec3SGrid, openvdb::Vec3DGrid, openvdb::Vec3IGrid>;
TYPED_TEST_SUITE(CompareTypes, Types);

TYPED_TEST(CompareTypes, FindTheOneVoxelAmongTilesAndVoxels)
{
    auto a = TypeParam::create();
    a->tree().addTile(1, Coord(8, 0, 0), Example<TypeParam>::value(1), true);
    for (int n = 0; n < 200; ++n)
        a->tree().setValue(Coord(-n, n, 3 * n), Example<TypeParam>::value(1));
    auto b = a->deepCopy();
    b->tree().voxelizeActiveTiles();
    EXPECT_EQ(compareGrids(*a, *b).verdict(), Verdict::kSame);
    b->tree().setValue(Coord(9, 3, 4), Example<TypeParam>::value(0));
    const GridDifference result = compareGrids(*a, *b);
    ASSERT_TRUE(result.values);
    EXPECT_EQ(result.values->failing, 1u);
    EXPECT_EQ(result.values->compared, 712u);
    EXPECT_EQ(result.values->error.max, (std::is_floating_point_v<typename TypeParam::ValueType> ? 0.5 : 1.));
    EXPECT_EQ(result.values->worst->index, (std::array<std::int64_t, 3>{9, 3, 4}));

    const auto grid = differenceGrid(*a, *b);
    ASSERT_TRUE(grid);
    EXPECT_EQ(grid->activeVoxelCount(), 712u);
}

TEST(CompareTypesExactly, LargeIntegersThatDifferByOneDiffer)
{
    const std::int64_t large = (std::int64_t(1) << 60) + 1;
    auto a = openvdb::Int64Grid::create(), b = openvdb::Int64Grid::create();
    a->tree().setValue(Coord(0), large);
    b->tree().setValue(Coord(0), large - 1);
    EXPECT_EQ(compareGrids(*a, *b).values->error.max, 1.);
    a->tree().setValue(Coord(0), std::numeric_limits<std::int64_t>::max());
    b->tree().setValue(Coord(0), std::numeric_limits<std::int64_t>::min());
    EXPECT_EQ(compareGrids(*a, *b).values->error.max, 18446744073709551615.);
}

TEST(CompareTypesExactly, TinyDifferencesOfDoublesDoNotVanish)
{
    auto a = openvdb::Vec3DGrid::create(), b = openvdb::Vec3DGrid::create();
    a->tree().setValue(Coord(0), openvdb::Vec3d(1e-200, 0, 0));
    b->tree().setValue(Coord(0), openvdb::Vec3d(0, 0, 0));
    EXPECT_EQ(compareGrids(*a, *b).values->failing, 1u);
}

TEST(CompareTypesExactly, VectorsAreMeasuredByLengthAndByComponent)
{
    auto a = openvdb::Vec3SGrid::create(), b = openvdb::Vec3SGrid::create();
    a->tree().setValue(Coord(0), openvdb::Vec3f(1, 2, 3));
    b->tree().setValue(Coord(0), openvdb::Vec3f(4, -2, 3)); // off by (3, 4, 0)
    a->tree().setValue(Coord(1), openvdb::Vec3f(0, 0, 0));
    b->tree().setValue(Coord(1), openvdb::Vec3f(0, 0, 0));
    const ValueDifference values = *compareGrids(*a, *b).values;
    EXPECT_EQ(values.error.max, 5.);
    EXPECT_EQ(values.error.mean, 2.5);
    EXPECT_EQ(values.error.rms, std::sqrt(12.5));
    ASSERT_EQ(values.components.size(), 3u);
    EXPECT_EQ(values.components[0].max, 3.);
    EXPECT_EQ(values.components[1].mean, 2.);
    EXPECT_EQ(values.components[1].rms, std::sqrt(8.));
    EXPECT_EQ(values.components[2].max, 0.);
    EXPECT_EQ(compareGrids(*a, *b, {.fail = 5}).verdict(), Verdict::kSame);
    EXPECT_EQ(compareGrids(*a, *b, {.fail = 4.9}).verdict(), Verdict::kDiffers);
}

TEST(CompareTypesExactly, MasksDifferByTheirTopology)
{
    auto a = openvdb::MaskGrid::create(), b = openvdb::MaskGrid::create();
    a->tree().addTile(1, Coord(0), true, true);
    b->tree().addTile(1, Coord(0), true, true);
    b->tree().voxelizeActiveTiles();
    EXPECT_EQ(compareGrids(*a, *b).verdict(), Verdict::kSame);
    b->tree().setValueOff(Coord(1, 2, 3));
    const GridDifference result = compareGrids(*a, *b);
    EXPECT_EQ(result.verdict(), Verdict::kDiffers);
    EXPECT_EQ(result.values->onlyInA, 1u);
    EXPECT_EQ(result.values->first->index, (std::array<std::int64_t, 3>{1, 2, 3}));
}

TEST(DifferenceGrid, HoldsTheAbsoluteDifferenceOnTheActiveVoxelsOfBoth)
{
    auto a = openvdb::FloatGrid::create(9.f), b = openvdb::FloatGrid::create(7.f);
    a->setName("density");
    a->setTransform(openvdb::math::Transform::createLinearTransform(0.25));
    a->tree().addTile(1, Coord(0), 1.f, true);
    b->tree().addTile(1, Coord(0), 3.f, true);
    b->tree().addTile(1, Coord(8, 0, 0), 2.f, true);
    a->tree().setValue(Coord(9, 1, 1), 1.5f);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    a->tree().setValue(Coord(50, 0, 0), nan);
    b->tree().setValue(Coord(50, 0, 0), nan);
    a->tree().setValue(Coord(51, 0, 0), nan);
    b->tree().setValue(Coord(51, 0, 0), 1.f);
    const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(differenceGrid(*a, *b));
    ASSERT_TRUE(grid);
    EXPECT_EQ(grid->getName(), "density");
    EXPECT_EQ(grid->voxelSize(), openvdb::Vec3d(0.25));
    EXPECT_EQ(grid->activeVoxelCount(), 512u + 512u + 2u);
    EXPECT_EQ(grid->background(), 0.f);
    EXPECT_EQ(grid->tree().getValue(Coord(1, 2, 3)), 2.f);
    EXPECT_EQ(grid->tree().getValue(Coord(9, 1, 1)), 0.5f);
    EXPECT_EQ(grid->tree().getValue(Coord(10, 1, 1)), 7.f); // A's background against B's tile
    EXPECT_EQ(grid->tree().getValue(Coord(50, 0, 0)), 0.f);
    EXPECT_TRUE(std::isinf(grid->tree().getValue(Coord(51, 0, 0))));
    EXPECT_FALSE(differenceGrid(*a, *openvdb::DoubleGrid::create()));
}

} // namespace
} // namespace vdblic
