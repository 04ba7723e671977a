#include "vdblic/coherence/coherence.h"

#include "methods/test_flow.h"
#include "vdblic/coherence/coherence_report.h"
#include "vdblic/coherence/smoothed_texture.h"
#include "vdblic/core/errors.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/noise/noise.h"

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

const CoherenceParams kFewer{.samples = 30'000};
const openvdb::CoordBBox kTextureBox({-3, 5, 2}, {76, 52, 49});

/// A texture whose values are a function of the voxel.
SmoothedTexture textureOf(const std::function<float(const Coord&)>& value, const openvdb::CoordBBox& box = kTextureBox)
{
    openvdb::FloatTree tree(0);
    for (auto voxel = box.begin(); voxel; ++voxel)
        tree.setValue(*voxel, value(*voxel));
    return SmoothedTexture(tree);
}

float whiteNoise(const Coord& at, std::uint32_t seed)
{
    return float(noiseValue(at[0], at[1], at[2], seed)) / float(kNoiseMax);
}

/// A sum of 20 waves of lengths from 8 to 16 voxels: smooth, and uncorrelated over longer distances.
float smoothField(const openvdb::Vec3d& at)
{
    double sum = 0;
    for (int wave = 0; wave < 20; ++wave) {
        const auto random = [&](int i) { return double(noiseValue(wave, i, 0, 3)) / kNoiseMax; };
        openvdb::Vec3d direction(random(0) - 0.5, random(1) - 0.5, random(2) - 0.5);
        direction.normalize();
        sum += std::sin(2 * M_PI * (direction.dot(at) / (8 + 8 * random(3)) + random(4)));
    }
    return float(0.5 + 0.06 * sum);
}

VelocityField fieldOf(const std::vector<VelocityFrame>& frames)
{
    VelocityField field;
    field.build(frames[0].domain, {frames[0].values->tree(), openvdb::Mat3d::identity()},
                {frames[1].values->tree(), openvdb::Mat3d::identity()});
    return field;
}

VelocityField uniformFlow(const Vec3f& velocity)
{
    return fieldOf(test::makeFrames(kTextureBox, 2, [&](const Coord&, int) { return velocity; }));
}

/// A velocity on the voxels of a box, for a texture that is finer. @param velocity [voxels of the velocity per step]
VelocityField uniformFlow(const Vec3f& velocity, const openvdb::CoordBBox& box, const Refinement& refinement)
{
    return fieldOf(test::refined(test::makeFrames(box, 2, [&](const Coord&, int) { return velocity; }), refinement));
}

openvdb::CoordBBox refinedBox(const openvdb::CoordBBox& box, const Refinement& refinement)
{
    const auto& [x, y, z] = refinement.factors;
    const Coord first(box.min()[0] * x, box.min()[1] * y, box.min()[2] * z);
    return {first, first.offsetBy(box.dim()[0] * x - 1, box.dim()[1] * y - 1, box.dim()[2] * z - 1)};
}

/// White noise averaged over some voxels along an axis.
float streaks(const Coord& at, int axis, int length)
{
    float sum = 0;
    for (Coord voxel = at; voxel[axis] < at[axis] + length; ++voxel[axis])
        sum += whiteNoise(voxel, 5);
    return sum / float(length);
}

double valueAt(double lag, const std::vector<double>& values, const std::array<int, 3>& factors)
{
    const std::vector<double> lags = coherenceLags(factors);
    const auto found = std::find(lags.begin(), lags.end(), lag);
    EXPECT_NE(found, lags.end()) << lag;
    return values[std::size_t(found - lags.begin())];
}

TEST(Coherence, OfATextureThatMovesWithTheFlowIsOne)
{
    const auto before = textureOf([](const Coord& at) { return smoothField(at.asVec3d()); });
    for (const Vec3f& velocity : {Vec3f(5, -2, 3), Vec3f(4.5f, 1.5f, -3.5f)}) {
        const auto after = textureOf([&](const Coord& at) { return smoothField(at.asVec3d() - velocity); });
        const FrameCoherence found = measureCoherence(before, &after, uniformFlow(velocity), kFewer, 1);
        EXPECT_GT(found.temporalPoints, 15000u);
        for (const CoherenceFigures& figures : {found.raw, found.smoothed}) {
            EXPECT_GT(figures.temporal, 0.985);
            EXPECT_LT(figures.samePlace, 0.5);
            EXPECT_DOUBLE_EQ(figures.gain, figures.temporal - figures.samePlace);
        }
    }
}

// After a shift by whole voxels, both ends of a path lie at the same position within their cells.
TEST(Coherence, OfWhiteNoiseMovedByWholeVoxelsIsOneAndOfOtherNoiseZero)
{
    const auto before = textureOf([](const Coord& at) { return whiteNoise(at, 1); });
    const auto moved = textureOf([](const Coord& at) { return whiteNoise(at - Coord(2, 1, 0), 1); });
    const auto other = textureOf([](const Coord& at) { return whiteNoise(at, 2); });
    const VelocityField field = uniformFlow(Vec3f(2, 1, 0));
    const FrameCoherence carried = measureCoherence(before, &moved, field, {}, 1);
    EXPECT_NEAR(carried.raw.temporal, 1, 1e-4);
    EXPECT_NEAR(carried.raw.samePlace, 0, 0.04); // some points share corners of cells, 60 % none
    const FrameCoherence unrelated = measureCoherence(before, &other, field, {}, 1);
    EXPECT_NEAR(unrelated.raw.temporal, 0, 0.02);
    EXPECT_NEAR(unrelated.smoothed.temporal, 0, 0.04);
}

TEST(Coherence, OfWhiteNoiseIsZeroAlongAndAcross)
{
    const auto texture = textureOf([](const Coord& at) { return whiteNoise(at, 1); });
    const FrameCoherence found = measureCoherence(texture, nullptr, uniformFlow(Vec3f(1, 1, 0.5f)), {}, 1);
    // Interpolated values share no voxel if they are more than a cell's diagonal and one voxel apart.
    for (std::size_t lag = 7; lag < found.raw.along.size(); ++lag) {
        EXPECT_NEAR(found.raw.along[lag], 0, 0.03) << lag;
        EXPECT_NEAR(found.raw.across[lag], 0, 0.03) << lag;
    }
    EXPECT_NEAR(found.raw.lengthRatio, 1, 0.2);
    EXPECT_LT(found.raw.alongLength, 1.5);
    EXPECT_GT(found.smoothed.alongLength, found.raw.alongLength);
    EXPECT_EQ(found.temporalPoints, 0u);
    EXPECT_TRUE(std::isnan(found.raw.temporal));
}

// The mean of n voxels of white noise along x has the autocorrelation max(0, 1 − lag / n). Interpolation along x lowers
// the variance by a share of 1 / (3n) and keeps the covariance at whole lags between 0 and n.
TEST(Coherence, FindsTheLengthOfStreaks)
{
    constexpr int kLength = 8;
    const auto texture = textureOf([](const Coord& at) { return streaks(at, 0, kLength); });
    CoherenceParams params;
    params.samples = 300'000;
    const FrameCoherence found = measureCoherence(texture, nullptr, uniformFlow(Vec3f(2, 0, 0)), params, 1);
    const double variance = 1 - 1 / (3.0 * kLength);
    for (const int lag : {2, 4, 6}) {
        EXPECT_NEAR(found.raw.along[std::size_t(2 * lag - 1)], (1 - double(lag) / kLength) / variance, 0.03) << lag;
    }
    EXPECT_NEAR(found.raw.along[19], 0, 0.05);
    EXPECT_NEAR(found.raw.alongLength, kLength * (1 - variance / M_E), 0.25);
    EXPECT_LT(found.raw.acrossLength, 1.5);
    EXPECT_GT(found.raw.lengthRatio, 3.5);
}

TEST(CoherenceLags, AreHalfVoxelsOfTheTextureAndThenOfTheVelocity)
{
    const std::vector<double> same = coherenceLags({1, 1, 1});
    ASSERT_EQ(same.size(), 32u);
    for (std::size_t lag = 0; lag < same.size(); ++lag)
        EXPECT_EQ(same[lag], 0.5 * double(lag + 1));
    for (const auto& factors :
         {std::array{2, 2, 2}, std::array{1, 3, 2}, std::array{7, 1, 1}, std::array{16, 16, 16}}) {
        const std::vector<double> lags = coherenceLags(factors);
        EXPECT_LE(lags.size(), 64u);
        EXPECT_EQ(lags[0], 0.5 / *std::max_element(factors.begin(), factors.end()));
        EXPECT_EQ(lags.back(), kLongestLag);
        EXPECT_EQ(std::adjacent_find(lags.begin(), lags.end(), std::greater_equal<>()), lags.end());
        for (const double lag : same)
            EXPECT_NE(std::find(lags.begin(), lags.end(), lag), lags.end()) << lag;
    }
}

// Of a texture of 40 voxels a streak, 3 in a voxel of the velocity: longer than 16 voxels of the texture.
TEST(Coherence, OfARefinedTextureIsInVoxelsOfTheVelocity)
{
    const Refinement refinement{{3, 3, 3}};
    constexpr int kLength = 40;
    const openvdb::CoordBBox box({-4, 2, 1}, {55, 13, 12});
    const auto texture =
        textureOf([](const Coord& at) { return streaks(at, 0, kLength); }, refinedBox(box, refinement));
    const FrameCoherence found =
        measureCoherence(texture, nullptr, uniformFlow(Vec3f(2, 0, 0), box, refinement), {.samples = 300'000}, 1);
    const double variance = 1 - 1 / (3.0 * kLength);
    for (const double lag : {2.0, 5.0, 9.0, 12.0}) {
        const double expected = (1 - 3 * lag / kLength) / variance;
        EXPECT_NEAR(valueAt(lag, found.raw.along, refinement.factors), expected, 0.04) << lag;
    }
    EXPECT_NEAR(found.raw.alongLength, kLength * (1 - variance / M_E) / 3, 0.35);
    EXPECT_NEAR(valueAt(kLongestLag, found.raw.along, refinement.factors), 0, 0.06);
    EXPECT_LT(found.raw.acrossLength, 1.5 / 3);
    EXPECT_GT(found.raw.acrossLength, 0.5 / 3);
}

// The same texture and the same motion, once with the velocity on the texture's voxels and once on coarser ones.
TEST(Coherence, DoesNotDependOnTheVelocitysVoxels)
{
    const Refinement refinement{{4, 4, 4}};
    const openvdb::CoordBBox box({-2, 1, 0}, {17, 12, 9});
    const auto before = textureOf([](const Coord& at) { return streaks(at, 0, 12); }, refinedBox(box, refinement));
    const auto after =
        textureOf([](const Coord& at) { return streaks(at - Coord(3, -2, 1), 0, 12); }, refinedBox(box, refinement));
    const Vec3f velocity(0.75f, -0.5f, 0.25f);
    const FrameCoherence coarse = measureCoherence(before, &after, uniformFlow(velocity, box, refinement), kFewer, 7);
    const FrameCoherence fine = measureCoherence(
        before, &after, uniformFlow(velocity * 4, refinedBox(box, refinement), Refinement{}), kFewer, 7);
    EXPECT_EQ(coarse.points, fine.points);
    EXPECT_EQ(coarse.temporalPoints, fine.temporalPoints);
    EXPECT_NEAR(coarse.raw.temporal, 1, 1e-4);
    EXPECT_NEAR(coarse.raw.temporal, fine.raw.temporal, 1e-6);
    EXPECT_NEAR(coarse.smoothed.samePlace, fine.smoothed.samePlace, 1e-6);
    for (std::size_t lag = 0; lag < fine.raw.along.size(); ++lag) { // up to 16 voxels of the texture
        EXPECT_NEAR(coarse.raw.along[lag], fine.raw.along[lag], 1e-4) << lag;
        EXPECT_NEAR(coarse.smoothed.across[lag], fine.smoothed.across[lag], 1e-4) << lag;
    }
    EXPECT_NEAR(coarse.raw.alongLength, fine.raw.alongLength / 4, 1e-4);
    EXPECT_NEAR(coarse.smoothed.acrossLength, fine.smoothed.acrossLength / 4, 1e-4);
    // The least motion is in voxels of the velocity: here 0.94 of its own and 3.7 of the texture's.
    EXPECT_EQ(measureCoherence(before, nullptr, uniformFlow(velocity, box, refinement), {.leastMotion = 1}, 7).points,
              0u);
}

TEST(Coherence, OfASmoothFieldIsTheSameForEveryRefinement)
{
    const openvdb::CoordBBox box({-3, 5, 2}, {56, 40, 37});
    const Vec3f velocity(3, -2, 1.5f);
    const auto measure = [&](const Refinement& refinement) {
        const auto moved = [&](const Vec3f& by) {
            const auto value = [&](const Coord& at) {
                openvdb::Vec3d index;
                for (int axis = 0; axis < 3; ++axis)
                    index[axis] = (at[axis] + 0.5) / refinement.factors[std::size_t(axis)] - 0.5;
                return smoothField(index - by);
            };
            return textureOf(value, refinedBox(box, refinement));
        };
        const auto before = moved(Vec3f(0)), after = moved(velocity);
        return measureCoherence(before, &after, uniformFlow(velocity, box, refinement), kFewer, 1);
    };
    const FrameCoherence plain = measure({});
    for (const Refinement& refinement : {Refinement{{2, 2, 2}}, Refinement{{3, 1, 2}}}) {
        const FrameCoherence found = measure(refinement);
        EXPECT_GT(found.raw.temporal, 0.985);
        EXPECT_NEAR(found.raw.samePlace, plain.raw.samePlace, 0.03);
        for (const double lag : {1.0, 2.0, 4.0, 8.0, 16.0}) {
            EXPECT_NEAR(valueAt(lag, found.raw.along, refinement.factors), valueAt(lag, plain.raw.along, {1, 1, 1}),
                        0.06)
                << lag;
        }
        EXPECT_NEAR(found.raw.alongLength, plain.raw.alongLength, 0.1);
        EXPECT_NEAR(found.raw.acrossLength, plain.raw.acrossLength, 0.1);
    }
}

// Streaks of 8 voxels of the velocity along any axis, with other numbers of texture voxels along each.
TEST(Coherence, OfAnAnisotropicRefinementIsTheSameAlongEveryAxis)
{
    const Refinement refinement{{4, 1, 2}};
    const openvdb::CoordBBox box({-9, 3, 2}, {18, 30, 29});
    for (int axis = 0; axis < 3; ++axis) {
        const int length = 8 * refinement.factors[std::size_t(axis)];
        const auto texture =
            textureOf([&](const Coord& at) { return streaks(at, axis, length); }, refinedBox(box, refinement));
        Vec3f velocity(0);
        velocity[axis] = 2;
        const FrameCoherence found =
            measureCoherence(texture, nullptr, uniformFlow(velocity, box, refinement), {.samples = 150'000}, 1);
        const double variance = 1 - 1 / (3.0 * length);
        for (const double lag : {2.0, 4.0, 6.0}) {
            EXPECT_NEAR(valueAt(lag, found.raw.along, refinement.factors), (1 - lag / 8) / variance, 0.06)
                << axis << ' ' << lag;
        }
        EXPECT_NEAR(found.raw.alongLength, 8 * (1 - variance / M_E), 0.3) << axis;
        EXPECT_LT(found.raw.acrossLength, 1.5) << axis; // of the coarsest texture voxels, at most
    }
}

// A texture that is constant on circles about an axis, in a flow that turns about it.
TEST(Coherence, FollowsTheStreamline)
{
    const auto radius = [](const Coord& at) { return std::hypot(at[0] - 36.5, at[1] - 28.5); };
    const auto frames = test::makeFrames(kTextureBox, 2, [&](const Coord& at, int) {
        return Vec3f(float(28.5 - at[1]) * 0.2f, float(at[0] - 36.5) * 0.2f, 0);
    });
    const VelocityField field = fieldOf(frames);
    const auto texture = textureOf([&](const Coord& at) { return float(0.5 + 0.4 * std::sin(radius(at))); });
    const FrameCoherence found = measureCoherence(texture, &texture, field, kFewer, 1);
    EXPECT_GT(found.raw.temporal, 0.99);
    EXPECT_GT(found.raw.along.back(), 0.98);
    EXPECT_EQ(found.raw.alongLength, kLongestLag);
    EXPECT_LT(found.raw.acrossLength, 4);
}

TEST(Coherence, DoesNotDependOnThreads)
{
    const auto before = textureOf([](const Coord& at) { return whiteNoise(at, 1); });
    const auto after = textureOf([](const Coord& at) { return whiteNoise(at - Coord(1, 0, 0), 1); });
    const VelocityField field = uniformFlow(Vec3f(1.2f, 0.3f, 0));
    CoherenceParams params;
    params.samples = 5000;
    std::vector<std::string> reports;
    for (const std::size_t threads : {1, 2, 7}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        SequenceCoherence coherence{};
        coherence.frames.push_back(measureCoherence(before, &after, field, params, 4));
        reports.push_back(toJson(coherence, {}));
    }
    EXPECT_EQ(reports[0], reports[1]);
    EXPECT_EQ(reports[0], reports[2]);
}

TEST(Coherence, TakesOnlyPointsWhereTheFlowMoves)
{
    const auto texture = textureOf([](const Coord& at) { return whiteNoise(at, 1); });
    const FrameCoherence still = measureCoherence(texture, &texture, uniformFlow(Vec3f(0.3f, 0.3f, 0)), kFewer, 1);
    EXPECT_EQ(still.points, 0u);
    EXPECT_TRUE(std::isnan(still.raw.temporal));
    EXPECT_TRUE(std::isnan(still.raw.alongLength));
    EXPECT_GT(measureCoherence(texture, &texture, uniformFlow(Vec3f(0.4f, 0.4f, 0)), kFewer, 1).points, 20000u);
}

TEST(SmoothedTexture, ContrastOfKnownTextures)
{
    const auto uniform = textureOf([](const Coord& at) { return whiteNoise(at, 1); });
    EXPECT_NEAR(uniform.rawContrast().deviation, std::sqrt(1 / 12.0), 0.002);
    EXPECT_NEAR(uniform.rawContrast().saturated, 1 / 255.0, 0.0005);
    // The squares of the weights sum to (1 + 4 + 1)³ / 4⁶; at the rim there are fewer weights.
    EXPECT_NEAR(uniform.smoothedContrast().deviation, std::sqrt(1 / 12.0 * 216 / 4096), 0.004);
    const auto checker = textureOf([](const Coord& at) { return float((at[0] + at[1] + at[2]) & 1); });
    EXPECT_DOUBLE_EQ(checker.rawContrast().deviation, 0.5);
    EXPECT_DOUBLE_EQ(checker.rawContrast().saturated, 1);
    EXPECT_EQ(checker.smoothedContrast().saturated, 0);
    const auto grey = textureOf([](const Coord&) { return 0.25f; });
    EXPECT_EQ(grey.rawContrast().deviation, 0);
    EXPECT_EQ(grey.rawContrast().saturated, 0);
}

TEST(SmoothedTexture, WeighsOnlyVoxelsThatHaveAValue)
{
    openvdb::FloatTree tree(0);
    tree.setValue({7, 0, 0}, 1);
    tree.setValue({8, 0, 0}, 0.25f); // in the next leaf
    tree.setValue({8, 1, 1}, 0.5f);
    const SmoothedTexture texture(tree);
    const auto at = [&](float x, float y, float z) { return texture.sample(Float4{x, y, z, 0}); };
    EXPECT_FALSE(at(7.5f, 0, 0.5f).inside);
    EXPECT_FALSE(at(6, 0, 0).inside);
    EXPECT_FALSE(at(7.5f, -0.25f, 0).inside); // below the first leaf
    ASSERT_TRUE(at(7.5f, 0, 0).inside);
    EXPECT_FLOAT_EQ(at(7.5f, 0, 0).raw, 0.625f);
    EXPECT_FLOAT_EQ(at(7, 0, 0).smoothed, (8 * 1 + 4 * 0.25f + 1 * 0.5f) / 13);
    EXPECT_FLOAT_EQ(at(8, 0, 0).smoothed, (4 * 1 + 8 * 0.25f + 2 * 0.5f) / 14);
}

TEST(CoherenceParams, AreChecked)
{
    for (const float motion : {0.0f, -1.0f, NAN, INFINITY}) {
        CoherenceParams params;
        params.leastMotion = motion;
        EXPECT_THROW(params.validate(), ParameterError) << motion;
    }
    CoherenceParams params;
    params.samples = 0;
    EXPECT_THROW(params.validate(), ParameterError);
}

} // namespace
} // namespace vdblic
