#include "vdblic/run/displacements.h"

#include "vdblic/flow/velocity_frame.h"

#include <gtest/gtest.h>

namespace vdblic {
namespace {

/// 20³ voxels along x, of size 1. @param speedOf index of a voxel
template<typename Speed>
double fasterHalf(const Speed& speedOf)
{
    VelocityFrame frame;
    frame.values = openvdb::Vec3SGrid::create();
    frame.values->tree().fill({{0, 0, 0}, {19, 19, 19}}, openvdb::Vec3s(0), true);
    frame.values->tree().voxelizeActiveTiles();
    for (auto value = frame.values->beginValueOn(); value; ++value)
        value.setValue({speedOf(value.getCoord()), 0, 0});
    Displacements displacements;
    displacements.add(frame, 0.5);
    return displacements.ofFasterHalf();
}

TEST(Displacements, OfAUniformFlowAreThatOfAnyVoxel)
{
    for (const float speed : {1e-8f, 0.3f, 68.0f, 2e5f})
        EXPECT_NEAR(fasterHalf([&](const openvdb::Coord&) { return speed; }) / (0.5 * double(speed)), 1, 0.01);
    EXPECT_EQ(fasterHalf([](const openvdb::Coord&) { return 0.0f; }), 0);
}

TEST(Displacements, NeitherStillAirNorAFastVoxelMatters)
{
    const auto jet = [](const openvdb::Coord& at) { return at.y() == 0 ? 8.0f : 0.0f; };
    EXPECT_NEAR(fasterHalf(jet), 4, 0.04);
    EXPECT_NEAR(fasterHalf([&](const openvdb::Coord& at) { return at == openvdb::Coord(0) ? 900.0f : jet(at); }), 4,
                0.04);
}

TEST(Displacements, HalfOfTheMotionIsFaster)
{
    // 1 and 3 voxels a step: the faster voxels have three quarters of the motion.
    EXPECT_NEAR(fasterHalf([](const openvdb::Coord& at) { return at.x() % 2 == 0 ? 2.0f : 6.0f; }), 3, 0.03);
}

} // namespace
} // namespace vdblic
