#include "vdblic/render/look.h"

#include "render/scene.h"

#include <gtest/gtest.h>

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
