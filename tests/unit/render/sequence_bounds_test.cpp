#include "vdblic/render/sequence_bounds.h"

#include "cast/test_scene.h"
#include "temporary_folder.h"
#include "vdblic/io/vdb_file.h"

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <openvdb/io/File.h>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::Vec3d;

class Bounds : public testing::Test {
  protected:
    /// A frame with a box of voxels, or none.
    void write(int frame, const CoordBBox& box, const openvdb::Mat4d& matrix = openvdb::Mat4d::identity())
    {
        const auto grid = boxGrid("density", box, scattered);
        grid->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
        mFiles.push_back({frame, mFolder / fmt::format("a.{}.vdb", frame)});
        // Another grid comes first and must be ignored.
        writeVdb(mFiles.back().path, {boxGrid("other", {Coord(-900), Coord(-898)}, scattered), grid}, {});
    }

    TemporaryFolder mFolder;
    std::vector<FrameFile> mFiles;
};

void expectCorner(const Corners& corners, std::size_t i, const Vec3d& expected)
{
    EXPECT_LT(glm::distance(corners[i], glm::dvec3(expected[0], expected[1], expected[2])), 1e-9) << i;
}

TEST_F(Bounds, AreOfAllFramesAlongASharedTransformsAxes)
{
    auto matrix = openvdb::math::scale<openvdb::Mat4d>(Vec3d(0.5, 2, -1));
    matrix.postRotate(openvdb::math::Z_AXIS, 0.5);
    write(1, {}, matrix);
    write(2, {Coord(0), Coord(3, 4, 5)}, matrix);
    write(3, {Coord(-20, 1, 1), Coord(2, 2, 2)}, matrix);
    const auto bounds = sequenceBounds(mFiles, "density");
    ASSERT_TRUE(bounds);
    EXPECT_EQ(bounds->firstFilled.frame, 2);
    const auto transform = openvdb::math::Transform::createLinearTransform(matrix);
    expectCorner(bounds->box, 0, transform->indexToWorld(Vec3d(-20.5, -0.5, -0.5)));
    expectCorner(bounds->box, 6, transform->indexToWorld(Vec3d(-20.5, 4.5, 5.5)));
    expectCorner(bounds->box, 7, transform->indexToWorld(Vec3d(3.5, 4.5, 5.5)));
}

TEST_F(Bounds, OfFramesThatMoveAreAlongTheWorldsAxes)
{
    write(1, {Coord(0), Coord(1)});
    write(2, {Coord(0), Coord(1)}, openvdb::math::scale<openvdb::Mat4d>(Vec3d(10)));
    const auto bounds = sequenceBounds(mFiles, "density");
    ASSERT_TRUE(bounds);
    expectCorner(bounds->box, 0, Vec3d(-5));
    expectCorner(bounds->box, 7, Vec3d(15));
}

TEST_F(Bounds, PassOverWhatHasNoVoxelsOrCannotBeRead)
{
    write(1, {});
    EXPECT_FALSE(sequenceBounds(mFiles, "density"));
    mFiles.push_back({2, mFolder.add("a.2.vdb", "no volume")});
    mFiles.push_back({3, mFolder / "a.3.vdb"});
    EXPECT_FALSE(sequenceBounds(mFiles, "density"));
    write(4, {Coord(0), Coord(1)});
    EXPECT_TRUE(sequenceBounds(mFiles, "density"));
    EXPECT_FALSE(sequenceBounds(mFiles, "smoke"));
}

TEST_F(Bounds, AreTakenFromTheVoxelsWhereTheHeaderDoesNotTell)
{
    const auto grid = boxGrid("density", {Coord(2), Coord(4)}, scattered);
    openvdb::io::File file(mFolder / "a.vdb");
    file.setGridStatsMetadataEnabled(false);
    file.write(openvdb::GridCPtrVec{grid});
    file.close();
    const auto bounds = sequenceBounds({{1, mFolder / "a.vdb"}}, "density");
    ASSERT_TRUE(bounds);
    expectCorner(bounds->box, 7, Vec3d(4.5));
}

} // namespace
} // namespace vdblic
