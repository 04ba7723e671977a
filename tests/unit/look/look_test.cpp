#include "vdblic/look/look.h"

#include "cast/test_scene.h"
#include "vdblic/core/errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace vdblic {
namespace {

using openvdb::Coord;

TEST(TextureModulation, StretchesBetweenItsEnds)
{
    const TextureModulation texture{0.4f, 0.6f, 1};
    const Float8 t = texture.stretched(Float8{-1, 0.4f, 0.5f, 0.6f, 2, std::nanf(""), 0.45f, 0.55f});
    const float expected[] = {0, 0, 0.5f, 1, 1};
    for (int i = 0; i < 5; ++i)
        EXPECT_NEAR(t[i], expected[i], 1e-6) << i;
    EXPECT_GE(t[5], 0);
    EXPECT_LE(t[5], 1);
}

TEST(TextureModulation, DarkTextureIsTransparentBrightTextureFull)
{
    const Float8 stretched = {0, 0.2f, 0.5f, 0.7f, 0.9f, 1};
    const Float8 strong = TextureModulation{0, 1, 1}.density(stretched);
    const Float8 none = TextureModulation{0, 1, 0}.density(stretched);
    EXPECT_EQ(strong[0], 0);
    EXPECT_EQ(strong[1], 0);
    EXPECT_NEAR(strong[5], 1, 1e-6);
    for (int i = 0; i < 6; ++i) {
        EXPECT_EQ(none[i], 1);
        EXPECT_NEAR((TextureModulation{0, 1, 0.5f}.density(stretched)[i]), (strong[i] + 1) / 2, 1e-6);
        EXPECT_GE(strong[i], strong[std::max(i - 1, 0)]);
    }
}

TEST(Look, IsChosenFromRobustPercentiles)
{
    const openvdb::CoordBBox box = boxOf(50, 20, 10);
    const auto texture = boxGrid("density", box, scattered);
    const auto driver = boxGrid("magnitude", box, [](const Coord& c) { return float(c.x() * 20 + c.y()); });
    driver->tree().setValueOn({3, 3, 3}, 1e9f); // one outlier
    const TextureVolume volume(*texture, *driver);
    const Look look = chooseLook({}, volume);
    EXPECT_NEAR(look.transfer.range()[0], 0.02 * 1000, 3);
    EXPECT_NEAR(look.transfer.range()[1], 0.99 * 1000, 3);
    EXPECT_NEAR(look.texture.low, 0.1, 0.01);
    EXPECT_NEAR(look.texture.high, 0.98, 0.01);
}

TEST(Look, ALogarithmicRangeIsChosenFromPositiveValues)
{
    const openvdb::CoordBBox box = boxOf(50, 20, 10);
    const auto texture = boxGrid("density", box, scattered);
    // A third is negative; the rest are powers of ten from −2 to 1.
    const auto driver = boxGrid("q", box, [](const Coord& c) {
        return c.x() % 3 == 0 ? -1.0f : float(std::pow(10, -2 + 3 * (c.y() + 0.5) / 20));
    });
    LookParams params;
    params.transfer.colorScale = ValueScale::kLogarithmic;
    const auto [low, high] = chooseLook(params, TextureVolume(*texture, *driver)).transfer.range();
    EXPECT_NEAR(std::log10(low), -2, 0.2);
    EXPECT_NEAR(std::log10(high), 1, 0.2);
    // At most four decades.
    const auto wide = boxGrid("q", box, [](const Coord& c) { return c.x() % 2 == 0 ? 1e-20f : 5.0f; });
    const auto ends = chooseLook(params, TextureVolume(*texture, *wide)).transfer.range();
    EXPECT_NEAR(ends[0], 5e-4, 1e-9);
    EXPECT_NEAR(ends[1], 5, 1e-6);
    const auto none = boxGrid("q", box, [](const Coord&) { return -1.0f; });
    EXPECT_THROW((void)chooseLook(params, TextureVolume(*texture, *none)), InputError);
}

TEST(Look, ALogarithmicPictureIsTheLinearOneOfLogarithms)
{
    // On a driver of steps, nothing is interpolated but at the steps.
    const auto texture = boxGrid("density", boxOf(24, 24, 24), [](const Coord&) { return 1.0f; });
    const auto powers = boxGrid("p", boxOf(24, 24, 24), [](const Coord& c) { return float(std::pow(10, c.y() / 6)); });
    const auto logarithms = boxGrid("l", boxOf(24, 24, 24), [](const Coord& c) { return float(c.y() / 6); });
    TransferParams params{.colorMap = "gray", .opacity = {{0, 0}, {1, 0.1}}, .range = {{0, 3}}};
    const Look linear{TransferFunction(params), {0, 1, 0, 0}, {.model = ShadingModel::kNone}};
    params.range = {{1, 1000}};
    params.colorScale = ValueScale::kLogarithmic;
    const Look logarithmic{TransferFunction(params), {0, 1, 0, 0}, {.model = ShadingModel::kNone}};
    const TextureVolume ofPowers(*texture, *powers), ofLogarithms(*texture, *logarithms);
    const Camera camera = cameraAlong(ofPowers, {1, 0, 0}, 1e5, 0.01, {40, 40});
    const Image a = castRays(ofPowers, logarithmic, camera, {}), b = castRays(ofLogarithms, linear, camera, {});
    int seen = 0;
    for (int row = 0; row < 40; ++row) {
        for (int x = 0; x < 40; ++x) {
            const Ray ray = camera.ray({x + 0.5, row + 0.5});
            const double y = ray.origin.y + ray.direction.y * (11.5 - ray.origin.x) / ray.direction.x;
            if (y < 0 || y > 23 || std::abs(std::fmod(y + 0.5, 6) - 3) > 2) continue; // beside a step
            ++seen;
            EXPECT_NEAR(a.at(x, row).a, b.at(x, row).a, 3e-3);
            EXPECT_NEAR(a.at(x, row).g, b.at(x, row).g, 3e-3);
        }
    }
    EXPECT_GT(seen, 100);
}

TEST(Look, TheOrderOfSamplesDoesNotMatter)
{
    VolumeSamples samples;
    for (int i = 0; i < 5000; ++i) {
        samples.texture.push_back(scattered({i, 0, 0}));
        samples.driver.push_back(scattered({0, i, 0}));
    }
    const Look look = chooseLook({}, samples, 30);
    std::reverse(samples.texture.begin(), samples.texture.end());
    std::reverse(samples.driver.begin(), samples.driver.end());
    const Look other = chooseLook({}, samples, 30);
    EXPECT_EQ(look.transfer.range(), other.transfer.range());
    EXPECT_EQ(look.texture.low, other.texture.low);
    EXPECT_EQ(opacityText(look.transfer.opacity()), opacityText(other.transfer.opacity()));
}

TEST(Look, SlowFlowIsSeenAndStillAirIsNot)
{
    // Half of the voxels move at a fifth of the highest speed, a few are fast, the others hardly move.
    VolumeSamples samples;
    for (int i = 0; i < 10000; ++i) {
        samples.texture.push_back(scattered({i, 0, 0}));
        samples.driver.push_back(i % 20 == 0 ? 10.0f : i % 2 == 0 ? 2.0f : 0.001f);
    }
    const double thickness = 50;
    const Look look = chooseLook({}, samples, thickness);
    double density = 0;
    for (const float texture : samples.texture)
        density += double(look.texture.density(look.texture.stretched(broadcast8(texture)))[0]) / 10000;
    const auto depth = [&](double value) {
        return -std::log1p(-look.transfer.opacityAt(look.transfer.opacityAxis().position(value))) * density * thickness;
    };
    EXPECT_GT(depth(2), 0.7);
    EXPECT_LT(depth(0.001), 0.01);
    // What opacity alone follows, such as q, hides what is near 0.
    samples.color = samples.driver;
    const Look vortex = chooseLook({}, samples, thickness);
    EXPECT_LT(vortex.transfer.opacityAt(vortex.transfer.opacityAxis().position(1)), look.transfer.opacityAt(0.1));
}

TEST(Look, WhatIsGivenIsKept)
{
    const auto grid = boxGrid("density", boxOf(9, 9, 9), scattered);
    const TextureVolume volume(*grid, *grid);
    LookParams params;
    params.transfer = {.colorMap = "viridis", .opacity = {{0, 0.25}}, .range = std::array{-3.0, 4.0}};
    params.textureStrength = 0.5;
    const Look look = chooseLook(params, volume);
    EXPECT_EQ(look.transfer.colorMapName(), "viridis");
    EXPECT_EQ(opacityText(look.transfer.opacity()), "0:0.25");
    EXPECT_EQ(look.transfer.range(), (std::array{-3.0, 4.0}));
    EXPECT_EQ(look.texture.strength, 0.5f);
}

TEST(Look, OneSeesAsFarIntoASmallVolumeAsIntoALargeOne)
{
    // The transmittance of a cube along an axis hardly depends on its size.
    double alphas[2];
    for (const int i : {0, 1}) {
        const int size = i == 0 ? 20 : 60;
        const auto texture = boxGrid("density", boxOf(size, size, size), scattered);
        const auto driver = boxGrid("magnitude", boxOf(size, size, size), [](const Coord& c) {
            return scattered({c.z(), c.x(), 5});
        });
        const TextureVolume volume(*texture, *driver);
        const Camera camera = cameraAlong(volume, {1, 0, 0}, size * 100.0, 0.3, {50, 50});
        const Image image = castRays(volume, chooseLook({}, volume), camera, {.leastTransmittance = 0});
        double sum = 0;
        for (const glm::vec4& pixel : image.pixels)
            sum += pixel.a;
        alphas[i] = sum / double(image.pixels.size());
    }
    EXPECT_GT(alphas[0], 0.5);
    EXPECT_LT(alphas[0], 0.98);
    EXPECT_NEAR(alphas[0], alphas[1], 0.06);
}

TEST(Look, FlowsOfOneSpeedAndTexturesOfOneValueShow)
{
    const auto grid = boxGrid("density", boxOf(16, 16, 16), [](const Coord&) { return 0.5f; });
    const TextureVolume volume(*grid, *grid);
    const Look look = chooseLook({}, volume);
    EXPECT_TRUE(look.contributes(volume.leafRange(0)));
    const Image image = castRays(volume, look, Camera({}, volume.corners(), {20, 20}), {});
    EXPECT_GT(image.at(10, 10).a, 0.5f);
    EXPECT_LT(image.at(10, 10).a, 1.0f);
}

} // namespace
} // namespace vdblic
