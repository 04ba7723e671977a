#include "vdblic/field/moved_velocity.h"

#include <gtest/gtest.h>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::Vec3d;
using openvdb::Vec3f;

/// A velocity that is linear in space, in a box whose middle is a tile.
openvdb::Vec3SGrid::Ptr linearVelocity(const CoordBBox& box)
{
    auto velocity = openvdb::Vec3SGrid::create(Vec3f(9));
    for (auto voxel = box.begin(); voxel; ++voxel)
        velocity->tree().setValue(*voxel, Vec3f((*voxel).asVec3d() * 0.5));
    velocity->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    return velocity;
}

TEST(MovedVelocity, ByWholeVoxelsHasTheSameBits)
{
    const CoordBBox box({-3, 2, 5}, {17, 13, 9});
    const auto velocity = linearVelocity(box);
    velocity->tree().addTile(1, Coord(64, 64, 64), Vec3f(7), true);
    const Coord shift(5, -11, 3);
    const auto moved = movedVelocity(*velocity, {openvdb::Mat3d::identity(), shift.asVec3d()}, std::nullopt);
    EXPECT_EQ(moved->activeVoxelCount(), velocity->activeVoxelCount());
    EXPECT_EQ(moved->transform(), velocity->transform());
    for (auto value = moved->cbeginValueOn(); value; ++value) {
        Vec3f there;
        EXPECT_TRUE(velocity->tree().probeValue(value.getCoord() + shift, there));
        EXPECT_EQ(*value, there);
    }
}

TEST(MovedVelocity, IsActiveWhereTheNearestVoxelIsAndMeansTheActiveCornersThere)
{
    const CoordBBox box({0, 0, 0}, {9, 9, 9});
    const auto velocity = linearVelocity(box);
    for (const double part : {0.25, 0.5, 0.75, 0.49999999999999994}) {
        const auto moved = movedVelocity(*velocity, {openvdb::Mat3d::identity(), Vec3d(part, 0, 0)}, std::nullopt);
        const int first = part < 0.49 ? 0 : -1; // the nearest voxel of a position half way is the upper one
        EXPECT_EQ(moved->evalActiveVoxelBoundingBox(), CoordBBox({first, 0, 0}, {first + 9, 9, 9})) << part;
        EXPECT_EQ(moved->activeVoxelCount(), 1000u);
        EXPECT_NEAR(moved->tree().getValue({4, 3, 2})[0], 0.5 * (4 + part), 1e-6);
        EXPECT_EQ(moved->tree().getValue({first + 9, 3, 2})[0], first < 0 ? float(0.5 * (8 + part)) : 4.5f);
        EXPECT_EQ(moved->tree().getValue({first, 3, 2})[0], first < 0 ? 0.0f : float(0.5 * part));
    }
}

TEST(MovedVelocity, TurnedKeepsItsVoxelsAndHasValuesInItsPartAlone)
{
    const CoordBBox box({0, 0, 0}, {30, 20, 10});
    const auto velocity = linearVelocity(box);
    const IndexMap turn{openvdb::math::rotation<openvdb::Mat3d>(Vec3d(0.6, 0, 0.8), 0.7), Vec3d(3, -2, 1)};
    const auto whole = movedVelocity(*velocity, turn, std::nullopt);
    EXPECT_NEAR(double(whole->activeVoxelCount()), double(box.volume()), 0.01 * double(box.volume()));
    const CoordBBox part({0, -8, 0}, {15, 7, 15});
    CoordBBox needed = turn.around(part);
    needed.min() &= ~7;
    const auto ofPart = movedVelocity(*velocity, turn, part);
    EXPECT_TRUE(ofPart->tree().hasSameTopology(whole->tree()));
    for (auto leaf = ofPart->tree().cbeginLeaf(); leaf; ++leaf) {
        EXPECT_EQ(leaf->buffer().empty(), !part.isInside(leaf->origin()));
        if (leaf->buffer().empty()) continue;
        for (auto value = leaf->cbeginValueOn(); value; ++value) {
            const Coord at = value.getCoord();
            EXPECT_EQ(*value, whole->tree().getValue(at));
            EXPECT_TRUE(needed.isInside(Coord::floor(turn.at(at.asVec3d()))));
            EXPECT_TRUE(needed.isInside(Coord::ceil(turn.at(at.asVec3d()))));
        }
    }
}

} // namespace
} // namespace vdblic
