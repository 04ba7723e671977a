#include "vdblic/methods/auflic/feedback.h"

#include "coherence/correlation.h"
#include "methods/test_flow.h"
#include "vdblic/core/errors.h"
#include "vdblic/lic/hits.h"
#include "vdblic/methods/auflic/release_turn.h"
#include "vdblic/noise/noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

constexpr std::uint32_t kSeed = 5;

/// A step from the first frame to the last.
VelocityField fieldOver(const std::vector<VelocityFrame>& frames)
{
    VelocityField field;
    field.build(frames.front().domain, {frames.front().values->tree(), openvdb::Mat3d::identity()},
                {frames.back().values->tree(), openvdb::Mat3d::identity()});
    return field;
}

/// A texture of one value on a domain, 0 outside as textures are.
LeafValues<float> uniformTexture(const Domain& domain, float value)
{
    LeafValues<float> texture(domain, 0);
    for (auto voxel = texture.tree()->beginValueOn(); voxel; ++voxel)
        voxel.setValue(value);
    return texture;
}

LeafValues<std::int32_t> feedForwardOver(const std::vector<VelocityFrame>& frames, const LeafValues<float>& texture,
                                         const Domain& next, const NoiseField& noise, const FeedbackParams& params,
                                         std::uint64_t step)
{
    VelocityField field = fieldOver(frames);
    return feedForward(field, texture, next, noise, params, step);
}

TEST(FeedForward, AVoxelNewInTheNextDomainTakesTheNoise)
{
    const auto frames = test::makeFrames({{0, 0, 0}, {11, 7, 7}}, 2, [](const Coord& at, int frame) {
        return at[0] < (frame == 0 ? 6 : 12) ? std::optional(Vec3f(0)) : std::nullopt;
    });
    const NoiseField noise(kSeed);
    const LeafValues<float> texture = uniformTexture(*frames[0].domain.texture, 0.25f);
    const auto next = feedForwardOver(frames, texture, *frames[1].domain.texture, noise, {}, 0);
    const auto original = noiseInput(*frames[1].domain.texture, noise);
    for (const Coord& at : openvdb::CoordBBox({6, 0, 0}, {11, 7, 7})) {
        EXPECT_EQ(next.tree()->getValue(at), original.tree()->getValue(at));
    }
    EXPECT_NE(next.tree()->getValue({2, 2, 2}), original.tree()->getValue({2, 2, 2}));
}

/// A texture of 0 to 1 without features larger than a voxel.
LeafValues<float> noisyTexture(const Domain& domain)
{
    LeafValues<float> texture(domain, 0);
    for (auto voxel = texture.tree()->beginValueOn(); voxel; ++voxel) {
        const Coord at = voxel.getCoord();
        voxel.setValue(float(noiseValue(at[0], at[1], at[2], kSeed)) / float(kNoiseMax));
    }
    return texture;
}

/// Slowing down from 10 to 2 voxels a step, fluid moves by 2 voxels in the second half of the step, as at a steady 4.
TEST(FeedForward, FluidIsFollowedBackAtItsSpeedInTheLastHalfStep)
{
    const openvdb::CoordBBox box({0, 0, 0}, {31, 7, 7});
    const auto steady = test::makeFrames(box, 1, [](auto&, int) { return Vec3f(4, 0, 0); });
    const auto slowing = test::makeFrames(box, 2, [](auto&, int frame) { return Vec3f(frame == 0 ? 10 : 2, 0, 0); });
    const LeafValues<float> texture = noisyTexture(*steady[0].domain.texture);
    const auto expected = feedForwardOver(steady, texture, *steady[0].domain.texture, NoiseField(kSeed), {}, 0);
    const auto next = feedForwardOver(slowing, texture, *steady[0].domain.texture, NoiseField(kSeed), {}, 0);
    for (const Coord& at : openvdb::CoordBBox({8, 0, 0}, {31, 7, 7})) { // whose fluid did not enter in this step
        EXPECT_EQ(next.tree()->getValue(at), expected.tree()->getValue(at)) << at;
    }
}

/// Where the velocity grows along x, half a step back counts the velocity a quarter of a step upstream.
TEST(FeedForward, FluidIsFollowedBackByTheVelocityMidway)
{
    const openvdb::CoordBBox box({0, 0, 0}, {31, 7, 7});
    const auto grown = [](float x) { return Vec3f((x + 8) / 8, 0, 0); };
    const auto growing = test::makeFrames(box, 1, [&](const Coord& at, int) { return grown(float(at[0])); });
    const LeafValues<float> texture = noisyTexture(*growing[0].domain.texture);
    const auto next = feedForwardOver(growing, texture, *growing[0].domain.texture, NoiseField(kSeed), {}, 0);
    for (int x = 12; x <= 28; ++x) {
        const Vec3f midway = grown(float(x) - grown(float(x))[0] / 4);
        const auto uniform = test::makeFrames(box, 1, [&](auto&, int) { return midway; });
        const auto expected = feedForwardOver(uniform, texture, *uniform[0].domain.texture, NoiseField(kSeed), {}, 0);
        const Coord at(x, 4, 4);
        EXPECT_NEAR(next.tree()->getValue(at), expected.tree()->getValue(at), 1) << x;
    }
}

TEST(FeedForward, FluidThatEntersBringsNewNoiseEveryStep)
{
    const auto frames = test::makeFrames({{0, 0, 0}, {15, 7, 7}}, 2, [](auto&, int) { return Vec3f(2, 0, 0); });
    VelocityField field = fieldOver(frames);
    const LeafValues<float> texture = uniformTexture(*frames[0].domain.texture, 0.25f);
    const auto first = feedForward(field, texture, *frames[1].domain.texture, NoiseField(kSeed), {}, 0);
    const auto second = feedForward(field, texture, *frames[1].domain.texture, NoiseField(kSeed), {}, 1);
    std::size_t differing = 0;
    for (const Coord& at : openvdb::CoordBBox({0, 0, 0}, {1, 7, 7})) {
        differing += first.tree()->getValue(at) != second.tree()->getValue(at);
    }
    EXPECT_GT(differing, 120u); // of 128
    for (const Coord& at : openvdb::CoordBBox({2, 0, 0}, {15, 7, 7})) {
        EXPECT_EQ(first.tree()->getValue(at), second.tree()->getValue(at));
    }
}

/// Uniform, oblique inflow: what enters is one pattern that moves with the flow, however long the steps are.
TEST(FeedForward, FluidThatEntersContinuesTheStreaksThatEnteredBefore)
{
    constexpr int kSubsteps = 4;
    const Vec3f velocity(6, 3, 0); // voxels a frame
    const auto frames = test::makeFrames({{0, 0, 0}, {23, 63, 7}}, 2, [&](auto&, int) { return velocity; });
    VelocityField field = fieldOver(frames);
    const LeafValues<float> texture = uniformTexture(*frames[0].domain.texture, 0.25f);
    const auto entered = [&](std::uint64_t step) {
        return feedForward(field, texture, *frames[1].domain.texture, NoiseField(kSeed), {}, step);
    };
    const auto first = entered(7), second = entered(8);
    test::Correlation streak, seam, across;
    const auto valueOf = [](const LeafValues<std::int32_t>& values, const Coord& at) {
        return double(values.tree()->getValue(at));
    };
    for (const Coord& at : openvdb::CoordBBox({0, 20, 0}, {3, 60, 7})) {
        streak.add(valueOf(first, at), valueOf(first, at + Coord(2, 1, 0)));
        // The fluid that was at the end of its first frame is ahead of the fluid that follows it.
        seam.add(valueOf(first, at), valueOf(second, at));
        across.add(valueOf(first, at), valueOf(first, at + Coord(0, 0, 1)));
    }
    EXPECT_GT(streak.value(), 0.9);
    EXPECT_GT(seam.value(), 0.4);
    EXPECT_LT(seam.value(), 0.9);
    EXPECT_LT(std::abs(across.value()), 0.2);
    // The same flow in steps of a quarter: the noise is about time, not about steps.
    VelocityField quarter;
    quarter.build(frames[0].domain, {frames[0].values->tree(), openvdb::Mat3d::identity() * (1.0 / kSubsteps)},
                  {frames[1].values->tree(), openvdb::Mat3d::identity() * (1.0 / kSubsteps)});
    const auto inQuarters =
        feedForward(quarter, texture, *frames[1].domain.texture, NoiseField(kSeed), {}, 8 * kSubsteps - 1, kSubsteps);
    std::size_t compared = 0;
    for (const Coord& at : openvdb::CoordBBox({0, 20, 0}, {4, 60, 7})) {
        if (!isReleaseTurn(at & ~7, 8 * kSubsteps, kSubsteps)) continue;
        EXPECT_EQ(inQuarters.tree()->getValue(at), first.tree()->getValue(at)) << at;
        ++compared;
    }
    EXPECT_GT(compared, 50u);
}

/// The mix filter as docs/algorithm.md has it, voxel by voxel in double precision, for fluid at rest.
class PlainMix {
  public:
    PlainMix(const std::map<Coord, double>& texture, const FeedbackParams& params) : mParams(params)
    {
        for (const auto& [at, value] : texture)
            mSharp[at] = sharpen(texture, at, value);
    }

    /// The value that a voxel's seed takes up, 0 to 1.
    [[nodiscard]] double value(const Coord& at) const
    {
        const auto [mean, deviation] = contrastAround(at);
        constexpr double kMaxGain = 16;
        const double gain = std::min(mParams.deviation / deviation, kMaxGain);
        const double restored = std::clamp(0.5 + gain * (mSharp.at(at) - mean), 0.0, 1.0);
        const double noise = noiseValue(at[0], at[1], at[2], kSeed) / 65535.0;
        return (1 - double(mParams.noiseShare)) * restored + double(mParams.noiseShare) * noise;
    }

  private:
    [[nodiscard]] double sharpen(const std::map<Coord, double>& texture, const Coord& at, double value) const
    {
        double sum = 0, count = 0;
        for (const Coord& step : openvdb::CoordBBox(Coord(-1), Coord(1))) {
            const auto neighbour = texture.find(at + step);
            if (step == Coord(0) || neighbour == texture.end()) continue;
            sum += neighbour->second;
            ++count;
        }
        return count > 0 ? value + double(mParams.sharpen) * (value - sum / count) : value;
    }

    /// Mean and deviation: a voxel counts by the distance of its block's centre, linearly down to 0 over a block's
    /// width of 4 along each axis.
    [[nodiscard]] std::pair<double, double> contrastAround(const Coord& at) const
    {
        double count = 0, sum = 0, squares = 0;
        for (const Coord& step : openvdb::CoordBBox(Coord(-6), Coord(6))) {
            double weight = 1;
            for (int axis = 0; axis < 3; ++axis) {
                const double centre = 4 * std::floor((at + step)[axis] / 4.0) + 1.5;
                weight *= std::max(0.0, 1 - std::abs(at[axis] - centre) / 4);
            }
            const auto voxel = weight > 0 ? mSharp.find(at + step) : mSharp.end();
            if (voxel == mSharp.end()) continue;
            count += weight;
            sum += weight * voxel->second;
            squares += weight * voxel->second * voxel->second;
        }
        const double mean = sum / count;
        return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean))};
    }

    FeedbackParams mParams;
    std::map<Coord, double> mSharp;
};

/// A texture of white noise: weak where x is below 8, strong elsewhere.
double textureAt(const Coord& at)
{
    const double noise = noiseValue(at[0], at[1], at[2], 99) / 65535.0;
    return at[0] < 8 ? 0.4 + 0.004 * noise : noise;
}

TEST(FeedForward, MixSharpensRestoresContrastAndAddsNoise)
{
    // Several leaves, with a ball and single voxels missing.
    const auto frames = test::makeFrames({{-3, -6, 2}, {19, 9, 13}}, 1, [](const Coord& at, int) {
        const bool inBall = (at - Coord(12, 2, 8)).asVec3d().lengthSqr() < 16;
        const bool isHole = noiseValue(at[0], at[1], at[2], 1) < 6000;
        return inBall || isHole ? std::nullopt : std::optional(Vec3f(0));
    });
    const Domain& domain = *frames[0].domain.texture;
    LeafValues<float> texture(domain, 0);
    std::map<Coord, double> plainTexture;
    for (auto voxel = domain.topology().cbeginValueOn(); voxel; ++voxel) {
        const Coord at = voxel.getCoord();
        texture.tree()->setValue(at, float(textureAt(at)));
        plainTexture[at] = textureAt(at);
    }
    for (const FeedbackParams& params :
         {FeedbackParams{}, FeedbackParams{.sharpen = 0, .noiseShare = 0, .deviation = 0.1f},
          FeedbackParams{.sharpen = 2.5f, .noiseShare = 0.4f, .deviation = 0.3f}}) {
        const PlainMix plain(plainTexture, params);
        const auto input = feedForwardOver(frames, texture, domain, NoiseField(kSeed), params, 0);
        std::size_t wrong = 0;
        for (auto value = input.tree()->cbeginValueOn(); value; ++value)
            wrong += !(std::abs(*value / 65535.0 - plain.value(value.getCoord())) < 5e-5);
        EXPECT_EQ(wrong, 0u) << "of " << domain.voxelCount() << " voxels, sharpened by " << params.sharpen;
    }
}

TEST(FeedbackParams, RefusesValuesOutOfRange)
{
    EXPECT_THROW(FeedbackParams{.sharpen = -1}.validate(), ParameterError);
    EXPECT_THROW(FeedbackParams{.noiseShare = 1.1f}.validate(), ParameterError);
    EXPECT_THROW(FeedbackParams{.deviation = 0}.validate(), ParameterError);
    EXPECT_THROW(FeedbackParams{.deviation = std::nanf("")}.validate(), ParameterError);
    EXPECT_NO_THROW(FeedbackParams{}.validate());
}

} // namespace
} // namespace vdblic
