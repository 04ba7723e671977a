#include "vdblic/methods/flow_texture.h"

#include "coherence/correlation.h"
#include "methods/test_flow.h"
#include "vdblic/field/slabs.h"
#include "vdblic/lic/hits.h"
#include "vdblic/methods/registry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;
using test::Correlation;

const openvdb::CoordBBox kFlowBox({0, 0, 0}, {47, 39, 39});

/// Correlation of texture a at x with texture b at x + shift, away from the rim.
Correlation shifted(const LeafValues<float>& a, const LeafValues<float>& b, const Coord& shift)
{
    Correlation correlation;
    for (openvdb::CoordBBox inner(Coord(12, 4, 4), Coord(35, 35, 35)); const Coord& at : inner) {
        correlation.add(a.tree()->getValue(at), b.tree()->getValue(at + shift));
    }
    return correlation;
}

std::vector<LeafValues<float>> texturesOf(const Vec3f& velocity, const TextureMethod* method, int steps)
{
    const auto frames = test::makeFrames(kFlowBox, steps + 1, [&](const Coord&, int) { return velocity; });
    TextureParams scatter;
    scatter.method = method;
    return test::streamedTextures(frames, steps, scatter);
}

class FlowTextures : public testing::TestWithParam<const TextureMethod*> {};

TEST_P(FlowTextures, OfAUniformFlowAreLongAlongItAndShortAcross)
{
    const auto textures = texturesOf(Vec3f(2, 0, 0), GetParam(), 12);
    const LeafValues<float>& texture = textures.back();
    EXPECT_GT(shifted(texture, texture, {2, 0, 0}).value(), 0.5);
    EXPECT_GT(shifted(texture, texture, {3, 0, 0}).value(), 0.3);
    // Sharpening correlates the nearest two neighbours; farther voxels are independent.
    for (const auto& [lag, bound] : {std::pair(1, 0.25), std::pair(2, 0.25), std::pair(3, 0.08), std::pair(4, 0.08)}) {
        EXPECT_LT(std::abs(shifted(texture, texture, {0, lag, 0}).value()), bound);
        EXPECT_LT(std::abs(shifted(texture, texture, {0, 0, lag}).value()), bound);
    }
    EXPECT_GT(shifted(texture, texture, {0, 0, 0}).deviation(), 0.08);
}

TEST_P(FlowTextures, MoveWithTheFlow)
{
    const auto textures = texturesOf(Vec3f(2, 0, 0), GetParam(), 12);
    const auto &before = textures[10], &after = textures[11];
    const double with = shifted(before, after, {2, 0, 0}).value();
    EXPECT_GT(with, 0.7);
    EXPECT_GT(with, shifted(before, after, {0, 0, 0}).value() + 0.05);
    EXPECT_GT(with, shifted(before, after, {5, 0, 0}).value() + 0.05);
}

TEST_P(FlowTextures, MoveAsFastAsTheFlow)
{
    // The lag at which the correlation over three steps peaks, from a parabola through the three highest lags.
    const auto textures = texturesOf(Vec3f(2, 0, 0), GetParam(), 14);
    std::array<double, 10> correlation{};
    for (int lag = 0; lag < 10; ++lag)
        correlation[std::size_t(lag)] = shifted(textures[10], textures[13], {lag, 0, 0}).value();
    const auto peak =
        std::size_t(std::max_element(correlation.begin() + 1, correlation.end() - 1) - correlation.begin());
    const double before = correlation[peak - 1], at = correlation[peak], after = correlation[peak + 1];
    const double distance = double(peak) + 0.5 * (before - after) / (before - 2 * at + after);
    EXPECT_NEAR(distance / 6, 1, 0.08);
}

TEST_P(FlowTextures, OfAFlowAtRestStayTheNoiseTheyWere)
{
    const auto textures = texturesOf(Vec3f(0), GetParam(), 12);
    const auto frames = test::makeFrames(kFlowBox, 1, [](const Coord&, int) { return Vec3f(0); });
    LeafValues<float> noise(*frames[0].domain.texture, 0.0f);
    const LeafValues<std::int32_t> input = noiseInput(*frames[0].domain.texture, NoiseField(7));
    for (auto value = input.tree()->cbeginValueOn(); value; ++value) {
        noise.tree()->setValue(value.getCoord(), float(*value) / 65535.0f);
    }
    EXPECT_GT(shifted(textures.back(), noise, {0, 0, 0}).value(), 0.9);
    EXPECT_NEAR(shifted(textures.back(), noise, {0, 0, 0}).mean(), 0.5, 0.02);
    EXPECT_GT(shifted(textures.back(), textures[8], {0, 0, 0}).value(), 0.99);
}

INSTANTIATE_TEST_SUITE_P(Methods, FlowTextures, testing::Values(&kUflic, &kAuflic));

TEST(FlowTexture, HandlesDomainsOfOneVoxelOneSheetAndNone)
{
    const auto still = [](const Coord&, int) { return Vec3f(0.3f, 0.2f, 0.1f); };
    for (const openvdb::CoordBBox& box :
         {openvdb::CoordBBox({7, 7, 7}, {7, 7, 7}), openvdb::CoordBBox({-9, 0, 4}, {20, 15, 4}),
          openvdb::CoordBBox({1, 1, 1}, {0, 0, 0})}) {
        const auto textures = test::streamedTextures(test::makeFrames(box, 6, still), 5, {});
        EXPECT_EQ(textures.back().tree()->activeVoxelCount(), box.empty() ? 0 : box.volume());
        for (auto value = textures.back().tree()->cbeginValueOn(); value; ++value) {
            EXPECT_TRUE(*value >= 0 && *value <= 1) << *value;
        }
    }
}

/// A domain of several slabs, in a flow with swirls.
std::vector<VelocityFrame> longFrames(int frames)
{
    return test::makeFrames({{0, 0, 0}, {399, 63, 63}}, frames, [](const Coord& at, int frame) {
        const float x = 0.1f * float(at[0]), y = 0.2f * float(at[1]), t = 0.5f * float(frame);
        return Vec3f(1.5f + std::sin(y + t), std::cos(x - t), std::sin(x + y));
    });
}

TEST(FlowTexture, IsTheSameWhetherTheVelocityIsHeldInPartsOrWhole)
{
    constexpr int kSteps = 2;
    const auto frames = longFrames(kSteps + 1);
    ASSERT_GT(Slabs(*frames[0].domain.texture).size(), 2u);
    // A fast voxel outside the domain raises the bound of the reach, so that all of the domain is held at once.
    auto fast = frames;
    for (VelocityFrame& frame : fast) {
        const auto grid = frame.values->deepCopy();
        grid->tree().setValue(Coord(-1000), Vec3f(1e4f));
        frame.values = grid;
    }
    const auto parts = test::streamedTextures(frames, kSteps, {}), whole = test::streamedTextures(fast, kSteps, {});
    for (std::size_t k = 0; k < parts.size(); ++k) {
        for (std::size_t leaf = 0; leaf < frames[k].domain.texture->leafCount(); ++leaf)
            ASSERT_TRUE(std::equal(parts[k][leaf], parts[k][leaf] + Domain::kLeafVoxels, whole[k][leaf])) << leaf;
    }
}

TEST(FlowTexture, CostsTheSameInEveryFrame)
{
    constexpr int kSteps = 16, kSettled = 6;
    const auto frames = test::makeFrames(kFlowBox, 2, [](const Coord& at, int) {
        return Vec3f(2, std::sin(0.2f * float(at[0])), std::cos(0.3f * float(at[1])));
    });
    const auto pipeline = makeFlowTexture({}, {NoiseField(7)});
    double least = 1e9, most = 0;
    for (int k = 0; k < kSteps; ++k) {
        const double steps = double(pipeline->advance(test::stepFrom(frames, 0)).stats.steps);
        if (k < kSettled) continue;
        least = std::min(least, steps);
        most = std::max(most, steps);
    }
    EXPECT_LT(most, 1.02 * least);
}

TEST(FlowTexture, AFrameWithoutVoxelsInTheMiddleIsPassedOver)
{
    auto frames = test::unsteadyFlowWithHole(8);
    frames[4] = test::makeFrames({{1, 1, 1}, {0, 0, 0}}, 1, [](auto&, int) { return Vec3f(0); })[0];
    const auto textures = test::streamedTextures(frames, 7, {});
    EXPECT_EQ(textures[4].tree()->activeVoxelCount(), 0u);
    EXPECT_EQ(textures[6].tree()->activeVoxelCount(), frames[6].domain.texture->voxelCount());
}

} // namespace
} // namespace vdblic
