#include "vdblic/lic/finish.h"

#include "methods/test_flow.h"
#include "vdblic/core/errors.h"
#include "vdblic/lic/along_flow.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

std::vector<VelocityFrame> flowAlong(const Vec3f& velocity)
{
    return test::makeFrames({{-4, 0, 0}, {19, 9, 9}}, 1, [=](const Coord&, int) { return velocity; });
}

LeafValues<float> finishedSpot(const VelocityFrame& frame, const Coord& spot, int taps)
{
    LeafValues<float> texture(*frame.domain.texture, 0.0f);
    texture.tree()->setValue(spot, 0.9f);
    return finish(frame, 1, texture, {taps, 0});
}

TEST(Finished, IsAMeanAlongTheFlowWithWeightsThatFallLinearly)
{
    const auto frames = flowAlong({0.3f, 0, 0}); // only the direction counts
    const LeafValues<float> result = finishedSpot(frames[0], {7, 4, 4}, 2);
    double sum = 0;
    for (auto value = result.tree()->cbeginValueOn(); value; ++value)
        sum += double(*value);
    EXPECT_NEAR(sum, 0.9, 1e-6);
    const float weights[] = {1, 2, 3, 2, 1};
    for (int i = 0; i < 5; ++i)
        EXPECT_NEAR(result.tree()->getValue({5 + i, 4, 4}), 0.9f * weights[i] / 9, 1e-6) << i;
}

TEST(Finished, LeavesOutTapsOutsideTheDomain)
{
    const auto frames = flowAlong({0, 5, 0});
    const LeafValues<float> result = finishedSpot(frames[0], {0, 0, 0}, 2);
    EXPECT_NEAR(result.tree()->getValue({0, 0, 0}), 0.9f * 3 / (3 + 2 + 1), 1e-6);
    EXPECT_NEAR(result.tree()->getValue({0, 1, 0}), 0.9f * 2 / (2 + 3 + 2 + 1), 1e-6);
}

TEST(Finished, LeavesStillFluidAndZeroTapsAsTheyAre)
{
    const auto still = flowAlong({0, 0, 0}), moving = flowAlong({1, 0, 0});
    EXPECT_FLOAT_EQ(finishedSpot(still[0], {3, 3, 3}, 2).tree()->getValue({3, 3, 3}), 0.9f);
    EXPECT_EQ(finishedSpot(moving[0], {3, 3, 3}, 0).tree()->getValue({3, 3, 3}), 0.9f);
    EXPECT_EQ(finishedSpot(moving[0], {3, 3, 3}, 0).tree()->getValue({4, 3, 3}), 0.0f);
}

/// Streaks along a refined, oblique flow stay as they are; sharpening raises their contrast within [0, 1].
TEST(Finished, KeepsStreaksOfARefinedFlow)
{
    // On texture voxels of a third by one half by one, velocity (2, 3, 0) is the direction (6, 6, 0): a diagonal.
    const auto frames = test::refined(flowAlong({2, 3, 0}), {{3, 2, 1}});
    LeafValues<float> texture(*frames[0].domain.texture, 0.0f);
    for (auto voxel = texture.tree()->beginValueOn(); voxel; ++voxel) {
        const Coord at = voxel.getCoord();
        voxel.setValue(0.5f + 0.4f * std::sin(0.7f * float(at[0] - at[1])));
    }
    const LeafValues<float> mean = finish(frames[0], 1, texture, {2, 0});
    const LeafValues<float> sharp = finish(frames[0], 1, texture, {2, 2});
    double before = 0, after = 0, most = 0;
    for (auto value = texture.tree()->cbeginValueOn(); value; ++value) {
        const Coord at = value.getCoord();
        if (at[0] < -6 || at[0] > 50 || at[1] < 4 || at[1] > 14) continue; // from the rim
        // Between voxels a streak is interpolated along its own diagonal and across it: a little fainter.
        most = std::max(most, double(std::abs(mean.tree()->getValue(at) - *value)));
        before += std::abs(*value - 0.5);
        after += std::abs(sharp.tree()->getValue(at) - 0.5);
    }
    EXPECT_LT(most, 0.06);
    EXPECT_GT(after, 1.1 * before);
    for (auto value = sharp.tree()->cbeginValueOn(); value; ++value)
        ASSERT_TRUE(*value >= 0 && *value <= 1);
}

TEST(Finished, DoesNotDependOnThreads)
{
    const auto frames = test::unsteadyFlowWithHole(2);
    const LeafValues<float> texture = test::streamedTextures(frames, 1, {})[0];
    std::vector<LeafValues<float>> results;
    for (const std::size_t threads : {1, 2, 7}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        results.push_back(finish(frames[0], 1, texture, {}));
    }
    for (auto value = results[0].tree()->cbeginValueOn(); value; ++value) {
        ASSERT_EQ(*value, results[1].tree()->getValue(value.getCoord()));
        ASSERT_EQ(*value, results[2].tree()->getValue(value.getCoord()));
    }
}

TEST(Finished, RefusesTapsBeyondTheNextLeaf)
{
    EXPECT_NO_THROW((FinishParams{kMostTaps, 1}.validate()));
    EXPECT_THROW((FinishParams{kMostTaps + 1, 1}.validate()), ParameterError);
    EXPECT_THROW((FinishParams{-1, 1}.validate()), ParameterError);
}

} // namespace
} // namespace vdblic
