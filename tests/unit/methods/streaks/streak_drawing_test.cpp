#include "vdblic/methods/streaks/streak_drawing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace vdblic {
namespace {

std::shared_ptr<const Domain> drawingDomain(const openvdb::CoordBBox& box)
{
    auto tree = std::make_shared<openvdb::MaskTree>();
    tree->fill(box, true, true);
    return std::make_shared<const Domain>(tree);
}

/// A streak that moves along x by two voxels a frame, from x = 2 at time 0 to x = 10 at time 4.
Streak straight(float y, float z, std::uint64_t name = 1)
{
    Streak streak{.name = name, .born = -10, .slidIn = true};
    for (int frame = 0; frame <= 4; ++frame)
        streak.path.push_back({{2 + 2 * float(frame), y, z}, {2, 0, 0}, double(frame)});
    return streak;
}

StreakShape shapeOf(float tail, int refine)
{
    return {{2, 2, 2}, tail, {{refine, refine, refine}}};
}

float valueAt(const openvdb::FloatTree& tree, int x, int y, int z)
{
    return tree.getValue({x, y, z});
}

TEST(StreakDrawing, RisesFromTheTailToTheHead)
{
    const auto domain = drawingDomain({{0, 0, 0}, {15, 7, 7}});
    const StreakShape shape = shapeOf(3, 8);
    const Streak streak = straight(3, 3);
    const DrawnStreaks drawn = drawStreaks({streak}, shape, *domain, 4, false);
    // Head at x = 10, tail from x = 4; texture voxel f lies at (f + ½)/8 − ½.
    const auto bright = float(streak.brightness(4));
    for (int x = 44; x <= 82; ++x) {
        const float at = (float(x) + 0.5f) / 8 - 0.5f, share = (at - 4) / 6;
        // The four voxels around the axis are ½ voxel from it along y and z.
        const float width = (0.45f + 0.55f * share) * 1.848f * shape.radius(0), off = 0.5f / (width * width);
        EXPECT_NEAR(valueAt(*drawn.texture, x, 27, 27), bright * share * (1 - off) * (1 - off), 0.01) << x;
    }
    EXPECT_EQ(valueAt(*drawn.texture, 34, 27, 27), 0); // before the tail
    EXPECT_EQ(valueAt(*drawn.texture, 87, 27, 27), 0); // beyond the head
}

TEST(StreakDrawing, WhatIsActiveIsSeen)
{
    const auto domain = drawingDomain({{0, 0, 0}, {15, 7, 7}});
    const DrawnStreaks drawn = drawStreaks({straight(3, 3)}, shapeOf(3, 8), *domain, 4, false);
    EXPECT_GT(drawn.texture->activeVoxelCount(), 200u);
    for (auto value = drawn.texture->cbeginValueOn(); value; ++value)
        EXPECT_GE(*value, 0.019f);
    for (auto value = drawn.texture->cbeginValueOff(); value; ++value)
        EXPECT_EQ(*value, 0);
}

TEST(StreakDrawing, IsTwoAndAHalfVoxelsThickAtHalfHeight)
{
    const StreakShape shape = shapeOf(3, 8);
    EXPECT_NEAR(2 * shape.radius(0), 2.5, 0.01);
    // Not drawn between voxels: the streak's axis goes through voxels' centres, whose neighbours are a voxel off.
    const auto domain = drawingDomain({{0, 0, 0}, {15, 7, 7}});
    const float centre = (28 + 0.5f) / 8 - 0.5f;
    const DrawnStreaks drawn = drawStreaks({straight(centre, centre)}, shape, *domain, 4, false);
    const float axis = valueAt(*drawn.texture, 80, 28, 28);
    EXPECT_GT(valueAt(*drawn.texture, 80, 29, 28), 0.5f * axis);
    EXPECT_LT(valueAt(*drawn.texture, 80, 30, 28), 0.5f * axis);
    EXPECT_EQ(valueAt(*drawn.texture, 80, 31, 28), 0);
}

TEST(StreakDrawing, EndsAtTheDomain)
{
    const auto domain = drawingDomain({{0, 0, 0}, {7, 3, 7}});
    const DrawnStreaks drawn = drawStreaks({straight(3.3f, 3)}, shapeOf(3, 4), *domain, 4, false);
    openvdb::CoordBBox box;
    ASSERT_TRUE(drawn.texture->evalActiveVoxelBoundingBox(box));
    EXPECT_LE(box.max()[0], 31);
    EXPECT_EQ(box.max()[1], 15);
    EXPECT_EQ(box.max()[0], 31);
}

TEST(StreakDrawing, TakesNoTimeForWhatLiesFarFromTheDomain)
{
    const auto domain = drawingDomain({{0, 0, 0}, {15, 7, 7}});
    for (const float speed : {1e8f, 1e12f, 1e30f}) {
        Streak fast = straight(3, 3, 2);
        for (StreakNode& node : fast.path) {
            node.position[0] = float(node.time - 2) * speed;
            node.slope[0] = speed;
        }
        const DrawnStreaks drawn = drawStreaks({straight(3, 3), fast}, shapeOf(3, 8), *domain, 4, false);
        EXPECT_GT(valueAt(*drawn.texture, 80, 27, 27), 0.5f) << speed;
    }
}

TEST(StreakDrawing, OrderDoesNotMatter)
{
    const auto domain = drawingDomain({{0, 0, 0}, {15, 7, 7}});
    std::vector<Streak> streaks;
    for (std::uint64_t i = 0; i < 12; ++i) {
        streaks.push_back(straight(2 + 0.2f * float(i % 4), 3 + 0.15f * float(i), i + 1));
        streaks.back().source = std::uint8_t(i % 3);
    }
    const StreakShape shape = shapeOf(3, 8);
    const DrawnStreaks one = drawStreaks(streaks, shape, *domain, 4, true);
    std::reverse(streaks.begin(), streaks.end());
    const DrawnStreaks other = drawStreaks(streaks, shape, *domain, 4, true);
    EXPECT_GT(one.texture->activeVoxelCount(), 1000u);
    EXPECT_TRUE(one.texture->hasSameTopology(*other.texture));
    for (auto value = one.texture->cbeginValueOn(); value; ++value) {
        EXPECT_EQ(*value, other.texture->getValue(value.getCoord()));
        EXPECT_EQ(one.source->getValue(value.getCoord()), other.source->getValue(value.getCoord()));
    }
}

TEST(StreakDrawing, NothingIsBrighterThanTheBrightestStreak)
{
    const auto domain = drawingDomain({{0, 0, 0}, {15, 7, 7}});
    const std::vector<Streak> streaks(50, straight(3, 3));
    const DrawnStreaks drawn = drawStreaks(streaks, shapeOf(3, 8), *domain, 4, false);
    for (auto value = drawn.texture->cbeginValueOn(); value; ++value)
        EXPECT_LE(*value, float(streaks.front().brightness(4)));
}

TEST(StreakDrawing, FadesInAndOut)
{
    Streak streak = straight(3, 3);
    const double full = streak.brightness(4);
    EXPECT_GE(full, 0.6);
    EXPECT_LE(full, 1);
    streak.retired = 4;
    EXPECT_EQ(streak.brightness(4), full);
    EXPECT_NEAR(streak.brightness(4.75), 0.5 * full, 1e-12);
    EXPECT_TRUE(streak.isGone(5.5, 3));
    Streak young = straight(3, 3);
    young.slidIn = false;
    young.born = 3.25;
    EXPECT_NEAR(young.brightness(4), 0.5 * full, 1e-12);
}

} // namespace
} // namespace vdblic
