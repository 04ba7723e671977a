#include "vdblic/field/coarser.h"

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;

TEST(Coarser, AVoxelIsTheMeanOfTheActiveOnesUnderIt)
{
    const auto fine = openvdb::FloatGrid::create();
    fine->tree().setValueOn(Coord(-1, -1, -1), 3);
    fine->tree().setValueOn(Coord(-2, -1, -2), 5);
    fine->tree().setValueOff(Coord(-2, -2, -2), 100);
    fine->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    for (const bool countsEmpty : {false, true}) {
        const auto coarse = openvdb::gridPtrCast<openvdb::FloatGrid>(coarser(*fine, countsEmpty));
        EXPECT_EQ(coarse->activeVoxelCount(), 1u);
        EXPECT_TRUE(coarse->tree().isValueOn(Coord(-1)));
        EXPECT_EQ(coarse->tree().getValue(Coord(-1)), countsEmpty ? 1 : 4);
        EXPECT_EQ(coarse->indexToWorld(Coord(-1)), fine->indexToWorld(openvdb::Vec3d(-1.5)));
        EXPECT_EQ(coarse->voxelSize(), openvdb::Vec3d(1));
    }
}

TEST(Coarser, ComponentsOnFacesAreMeansOverFaces)
{
    const auto fine = openvdb::Vec3SGrid::create();
    fine->setGridClass(openvdb::GRID_STAGGERED);
    const CoordBBox box(Coord(0), Coord(7));
    for (auto voxel = box.begin(); voxel; ++voxel)
        fine->tree().setValueOn(*voxel, openvdb::Vec3f((*voxel).asVec3s()));
    const auto coarse = openvdb::gridPtrCast<openvdb::Vec3SGrid>(coarser(*fine, false));
    EXPECT_EQ(coarse->activeVoxelCount(), 64u);
    EXPECT_EQ(coarse->tree().getValue(Coord(1, 2, 3)), openvdb::Vec3f(2, 4, 6)); // the lower faces
}

TEST(Coarser, TilesCountAsTheirVoxels)
{
    const auto fine = openvdb::DoubleGrid::create();
    fine->fill(CoordBBox(Coord(0), Coord(127)), 2.0);
    const auto coarse = openvdb::gridPtrCast<openvdb::FloatGrid>(coarser(*fine, false));
    EXPECT_EQ(coarse->activeVoxelCount(), 64u * 64 * 64);
    EXPECT_EQ(coarse->tree().getValue(Coord(63)), 2);
}

TEST(Coarser, OtherGridsHaveNone)
{
    EXPECT_EQ(coarser(*openvdb::Int32Grid::create(), false), nullptr);
}

} // namespace
} // namespace vdblic
