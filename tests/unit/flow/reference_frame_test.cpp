#include "vdblic/flow/reference_frame.h"

#include "vdblic/core/errors.h"

#include <gtest/gtest.h>

#include <limits>

namespace vdblic {
namespace {

using openvdb::Vec3d;

openvdb::math::Transform::Ptr anisotropicVoxels()
{
    auto voxels = openvdb::math::Transform::createLinearTransform();
    voxels->preScale(Vec3d(0.5, 0.25, 2));
    voxels->postTranslate(Vec3d(3, -1, 7));
    return voxels;
}

TEST(ReferenceFrame, MapsVoxelsAndGridsByTheSameMotion)
{
    const auto voxels = anisotropicVoxels();
    for (const double rotation : {0.0, 7.0}) {
        const ReferenceFrame frame({.velocity = {{0.3, -1, 0.1}}, .rotation = rotation, .axis = {{1, 2, -1}}}, *voxels);
        for (const double seconds : {0.0, 1.7, -2.3}) {
            const Vec3d index(4, -3, 11);
            const Vec3d world = frame.toWorld(*voxels, seconds)->indexToWorld(index);
            EXPECT_TRUE(voxels->indexToWorld(frame.toWorldVoxels(seconds).at(index)).eq(world, 1e-12));
            const auto back = frame.fromWorld(*frame.toWorld(*voxels, seconds), seconds);
            EXPECT_TRUE(back->indexToWorld(index).eq(voxels->indexToWorld(index), 1e-12));
        }
    }
}

TEST(ReferenceFrame, SeesTheVelocityOfWhatMovesInItsSpace)
{
    const auto voxels = anisotropicVoxels();
    const ReferenceFrame frame(
        {.velocity = {{0.3, -1, 0.1}}, .rotation = 7, .axis = {{1, 2, -1}}, .point = {{2, 0, 1}}}, *voxels);
    const Vec3d place(4, -3, 11), velocity(0.2, 0.5, -0.7);
    constexpr double kTime = 1.7, kStep = 1e-4;
    // A particle of the observer's space, in the world.
    const auto world = [&](double time) {
        const Vec3d at = place + velocity * (time - kTime);
        return frame.toWorld(*voxels, time)->indexToWorld(voxels->worldToIndex(at));
    };
    const Vec3d ofWorld = (world(kTime + kStep) - world(kTime - kStep)) / (2 * kStep);
    EXPECT_TRUE(frame.unseen(kTime).at(velocity, place).eq(ofWorld, 1e-7));
    EXPECT_TRUE(frame.seen(kTime).at(ofWorld, place).eq(velocity, 1e-7));
}

TEST(ReferenceFrame, MovesByWholeVoxelsExactly)
{
    const auto voxels = anisotropicVoxels();
    const ReferenceFrame frame({.velocity = {{0.5 / 0.3, -0.25 / 0.3, 6 / 0.3}}}, *voxels);
    EXPECT_EQ(frame.toWorldVoxels(3 * 0.3).shift, Vec3d(3, -3, 9));
    EXPECT_EQ(frame.toWorldVoxels(3 * 0.3 * (1 + 1e-6)).shift, Vec3d(3, -3, 9));
    EXPECT_NE(frame.toWorldVoxels(3 * 0.3 * (1 + 1e-3)).shift, Vec3d(3, -3, 9));
}

TEST(ReferenceFrame, IsKnownByMetadata)
{
    const auto voxels = anisotropicVoxels();
    openvdb::MetaMap metadata;
    const ReferenceFrameParams given{
        .velocity = {{1, 2, 3}}, .rotation = -4, .axis = {{0, 1, 0}}, .point = {{5, 6, 7}}};
    ReferenceFrame(given, *voxels).describe(metadata);
    const ReferenceFrameParams found = ReferenceFrame::describedIn(metadata);
    EXPECT_EQ(found.velocity, given.velocity);
    EXPECT_EQ(found.rotation, given.rotation);
    EXPECT_EQ(found.axis, given.axis);
    EXPECT_EQ(found.point, given.point);
    EXPECT_TRUE(ReferenceFrame::describedIn({}).isAtRest());
}

TEST(ReferenceFrame, RefusesWhatIsNoMotion)
{
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(ReferenceFrameParams({.velocity = {{0, kNaN, 0}}}).validate(), ParameterError);
    EXPECT_THROW(ReferenceFrameParams({.rotation = kNaN}).validate(), ParameterError);
    EXPECT_THROW(ReferenceFrameParams({.rotation = 1, .axis = {{0, 0, 0}}}).validate(), ParameterError);
    EXPECT_THROW(ReferenceFrameParams({.axis = {{0, 0, 1}}}).validate(), ParameterError);
    EXPECT_THROW(ReferenceFrameParams({.stay = true}).validate(), ParameterError);
    EXPECT_NO_THROW(ReferenceFrameParams({.followsMean = true, .stay = true}).validate());
}

} // namespace
} // namespace vdblic
