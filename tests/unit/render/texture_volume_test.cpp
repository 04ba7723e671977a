#include "vdblic/render/texture_volume.h"

#include "render/scene.h"
#include "vdblic/core/errors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3d;

Float8 recordAt(const TextureVolume& volume, float x, float y, float z)
{
    return Bricks::interpolate(volume.bricks().locate(Float4{x, y, z}));
}

TEST(TextureVolume, HoldsTheGradientOfALinearTextureInWorldSpace)
{
    // A texture that is linear in the world has one gradient everywhere, at the rim as well, for any transform.
    const Vec3d slope(0.3, -0.2, 0.5);
    openvdb::math::Mat4d matrix = openvdb::math::Mat4d::identity();
    matrix.setToRotation(Vec3d(1, -1, 2), 1.1);
    matrix.preScale(Vec3d(0.5, -2, 0.25));
    const auto transform = openvdb::math::Transform::createLinearTransform(matrix);
    const auto grid = boxGrid("density", boxOf(12, 10, 9),
                              [&](const Coord& c) { return float(transform->indexToWorld(c).dot(slope)); });
    grid->setTransform(transform);
    const TextureVolume volume(*grid, *grid);
    const double voxelSize = std::cbrt(0.5 * 2 * 0.25);
    for (const Coord& c : {Coord(0, 0, 0), Coord(11, 9, 8), Coord(5, 0, 8), Coord(7, 8, 7)}) {
        const Float8 record = recordAt(volume, float(c.x()), float(c.y()), float(c.z()));
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_NEAR(record[TextureVolume::kGradientX + axis], slope[axis] * voxelSize, 1e-5) << c << axis;
        }
        EXPECT_EQ(record[TextureVolume::kCoverage], 1);
    }
}

TEST(TextureVolume, KnowsTheRangeOfALeafAndItsNeighbours)
{
    const auto texture = boxGrid("density", boxOf(24, 8, 8), [](const Coord& c) { return c.x() == 16 ? 0.9f : 0.1f; });
    const auto magnitude = boxGrid("magnitude", boxOf(24, 8, 8), [](const Coord& c) { return float(c.x()); });
    const TextureVolume volume(*texture, *magnitude);
    ASSERT_EQ(volume.domain().leafCount(), 3u);
    EXPECT_EQ(volume.leafRange(0).lowMagnitude, 0);
    EXPECT_EQ(volume.leafRange(0).highMagnitude, 8);
    EXPECT_EQ(volume.leafRange(0).highTexture, 0.1f);
    EXPECT_EQ(volume.leafRange(1).lowMagnitude, 7);
    EXPECT_EQ(volume.leafRange(1).highMagnitude, 16);
    EXPECT_EQ(volume.leafRange(1).highTexture, 0.9f);
}

TEST(TextureVolume, BoundsReachToTheFacesOfTheOutermostVoxels)
{
    const auto grid = boxGrid("density", {Coord(-3, 4, 5), Coord(9, 9, 9)}, scattered);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(2.0));
    const TextureVolume volume(*grid, *grid);
    EXPECT_EQ(volume.low(), glm::dvec3(-3.5, 3.5, 4.5));
    EXPECT_EQ(volume.high(), glm::dvec3(9.5, 9.5, 9.5));
    EXPECT_EQ(volume.corners().front(), glm::dvec3(-7, 7, 9));
    EXPECT_EQ(volume.corners().back(), glm::dvec3(19, 19, 19));
}

TEST(TextureVolume, TilesAreVoxels)
{
    const auto grid = openvdb::FloatGrid::create();
    grid->sparseFill({Coord(0), Coord(31)}, 0.25f);
    ASSERT_GT(grid->tree().activeTileCount(), 0u);
    const TextureVolume volume(*grid, *grid);
    EXPECT_EQ(volume.domain().voxelCount(), 32u * 32 * 32);
    EXPECT_EQ(recordAt(volume, 7.5f, 15.5f, 9)[TextureVolume::kTexture], 0.25f);
}

TEST(TextureVolume, LeavesOutWhatIsNoNumber)
{
    const auto grid = boxGrid("density", boxOf(8, 8, 8), [](const Coord&) { return 0.5f; });
    grid->tree().setValueOn({3, 3, 3}, std::nanf(""));
    grid->tree().setValueOn({5, 5, 5}, HUGE_VALF);
    const TextureVolume volume(*grid, *grid);
    EXPECT_EQ(volume.unusableVoxels(), 2u);
    EXPECT_EQ(recordAt(volume, 3, 3, 3)[TextureVolume::kCoverage], 0);
    EXPECT_EQ(recordAt(volume, 2, 3, 3)[TextureVolume::kTexture], 0.5f);
    EXPECT_EQ(recordAt(volume, 2, 3, 3)[TextureVolume::kGradientX], 0);
    EXPECT_EQ(volume.leafRange(0).highTexture, 0.5f);
}

TEST(TextureVolume, RefusesTransformsItCannotRender)
{
    const auto grid = boxGrid("fog", boxOf(4, 4, 4), scattered);
    const auto other = grid->deepCopy();
    other->setName("speed");
    other->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    try {
        const TextureVolume volume(*grid, *other);
        FAIL() << "two transforms were taken";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("speed"), std::string::npos) << error.what();
    }
    grid->setTransform(
        openvdb::math::Transform::createFrustumTransform(openvdb::BBoxd(Vec3d(0), Vec3d(9)), 0.5, 10, 0.1));
    try {
        const TextureVolume volume(*grid, *grid);
        FAIL() << "a frustum was taken";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("fog"), std::string::npos) << error.what();
    }
}

} // namespace
} // namespace vdblic
