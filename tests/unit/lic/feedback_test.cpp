#include "vdblic/lic/feedback.h"

#include "lic/test_flow.h"
#include "vdblic/core/errors.h"
#include "vdblic/lic/hits.h"
#include "vdblic/lic/noise.h"

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
VelocityField fieldOver(const std::vector<FlowFrame>& frames)
{
    VelocityField field;
    field.build(frames.front().domain, {frames.front().velocities->tree(), openvdb::Mat3d::identity()},
                {frames.back().velocities->tree(), openvdb::Mat3d::identity()});
    return field;
}

TEST(FeedForward, AVoxelNewInTheNextDomainTakesTheNoise)
{
    const auto frames = test::makeFrames({{0, 0, 0}, {11, 7, 7}}, 2, [](const Coord& at, int frame) {
        return at[0] < (frame == 0 ? 6 : 12) ? std::optional(Vec3f(0)) : std::nullopt;
    });
    const NoiseField noise(kSeed);
    const LeafValues<float> texture(*frames[0].domain, 0.25f);
    const auto next = feedForward(fieldOver(frames), texture, *frames[1].domain, noise, {}, 0);
    const auto original = noiseInput(*frames[1].domain, noise);
    for (const Coord& at : openvdb::CoordBBox({6, 0, 0}, {11, 7, 7})) {
        EXPECT_EQ(next.tree()->getValue(at), original.tree()->getValue(at));
    }
    EXPECT_NE(next.tree()->getValue({2, 2, 2}), original.tree()->getValue({2, 2, 2}));
}

TEST(FeedForward, FluidThatEntersBringsNewNoiseEveryStep)
{
    const auto frames = test::makeFrames({{0, 0, 0}, {15, 7, 7}}, 2, [](auto&, int) { return Vec3f(2, 0, 0); });
    const VelocityField field = fieldOver(frames);
    const LeafValues<float> texture(*frames[0].domain, 0.25f);
    const auto first = feedForward(field, texture, *frames[1].domain, NoiseField(kSeed), {}, 0);
    const auto second = feedForward(field, texture, *frames[1].domain, NoiseField(kSeed), {}, 1);
    std::size_t differing = 0;
    for (const Coord& at : openvdb::CoordBBox({0, 0, 0}, {1, 7, 7})) {
        differing += Input::value(first.tree()->getValue(at)) != Input::value(second.tree()->getValue(at));
    }
    EXPECT_GT(differing, 120u); // of 128
    for (const Coord& at : openvdb::CoordBBox({2, 0, 0}, {15, 7, 7})) {
        EXPECT_EQ(first.tree()->getValue(at), second.tree()->getValue(at));
    }
}

TEST(FeedForward, BitsTakeTheTopBitFromTheTextureAndTheRestFromTheNoise)
{
    struct Known {
        float noise;
        double dark, bright; // results for a texture of 0.2 and of 0.8
    };
    // The rest of the noise after division by ½, below or above ½; under 0.1 and over 0.9 stretched to the ends.
    const std::array<Known, 6> known = {{{0.05f, 0, 0.55},
                                         {0.25f, 0.25, 0.75},
                                         {0.45f, 0.45, 1},
                                         {0.55f, 0, 0.55},
                                         {0.75f, 0.25, 0.75},
                                         {0.95f, 0.45, 1}}};
    const auto frames = test::makeFrames({{0, 0, 0}, {5, 0, 0}}, 1, [](auto&, int) { return Vec3f(0); });
    const auto grid = openvdb::FloatGrid::create();
    for (int x = 0; x < int(known.size()); ++x)
        grid->tree().setValue({x, 0, 0}, known[std::size_t(x)].noise);
    FeedbackParams params;
    params.jitter = Jitter::kBits;
    for (const bool bright : {false, true}) {
        const LeafValues<float> texture(*frames[0].domain, bright ? 0.8f : 0.2f);
        const auto next =
            feedForward(fieldOver(frames), texture, *frames[0].domain, NoiseField(kSeed, grid), params, 0);
        for (int x = 0; x < int(known.size()); ++x) {
            const Known& expected = known[std::size_t(x)];
            EXPECT_NEAR(Input::value(next.tree()->getValue({x, 0, 0})) / 65535.0,
                        bright ? expected.bright : expected.dark, 3e-5)
                << expected.noise << " and a texture of " << (bright ? 0.8 : 0.2);
        }
    }
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
    const Domain& domain = *frames[0].domain;
    const LeafValues<float> texture(domain, 0);
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
        const auto input = feedForward(fieldOver(frames), texture, domain, NoiseField(kSeed), params, 0);
        std::size_t wrong = 0, wrongHistories = 0;
        for (auto word = input.tree()->cbeginValueOn(); word; ++word) {
            const double value = Input::value(*word) / 65535.0, before = plainTexture.at(word.getCoord());
            wrong += !(std::abs(value - plain.value(word.getCoord())) < 5e-5);
            // Three quarters of the texture, one of the jittered value.
            wrongHistories += !(std::abs(Input::history(*word) / 65535.0 - (3 * before + value) / 4) < 3e-5);
        }
        EXPECT_EQ(wrong, 0u) << "of " << domain.voxelCount() << " voxels, sharpened by " << params.sharpen;
        EXPECT_EQ(wrongHistories, 0u);
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

TEST(FeedbackParams, JittersHaveNames)
{
    EXPECT_EQ(parseJitter("mix"), Jitter::kMix);
    EXPECT_EQ(toString(parseJitter("bits")), "bits");
    EXPECT_THROW((void)parseJitter("noise"), ParameterError);
}

} // namespace
} // namespace vdblic
