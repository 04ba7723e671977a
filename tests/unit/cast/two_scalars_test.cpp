#include "cast/test_scene.h"
#include "vdblic/core/errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace vdblic {
namespace {

using openvdb::Coord;

openvdb::FloatGrid::Ptr ramp(const std::string& name, float low, float perX, float perY)
{
    return boxGrid(name, boxOf(32, 24, 24),
                   [=](const Coord& c) { return low + perX * float(c.x()) + perY * float(c.y()); });
}

TEST(TwoScalars, OneColoursAndTheOtherMakesOpaque)
{
    // Along x the opacity rises; along y the colour does. The reference pixel is the sum over the steps of its ray.
    const auto texture = ramp("density", 1, 0, 0), opaque = ramp("q", -3, 0.25f, 0),
               colors = ramp("speed", 40, 0, 0.5f);
    TextureVolume volume(*texture, *opaque);
    volume.addColors(*texture, *colors);
    const TransferFunction transfer(
        {.colorMap = "gray", .opacity = {{0, 0}, {1, 0.2}}, .range = {{40, 50}}, .opacityRange = {{0, 4}}});
    const Look look{transfer, {0, 1, 0, 0}, {.model = ShadingModel::kNone}};
    const Camera camera = cameraAlong(volume, {1, 0, 0}, 1e5, 0.008, {20, 20});
    const Image image = castRays(volume, look, camera, {.step = 0.1, .leastTransmittance = 0, .layers = true});
    for (const int x : {4, 10, 15}) {
        const Ray ray = camera.ray({x + 0.5, 10.5});
        const double y = ray.origin.y + ray.direction.y * (11.5 - ray.origin.x) / ray.direction.x;
        double depth = 0;
        constexpr int kSteps = 3200;
        for (int i = 0; i < kSteps; ++i) {
            const double q = std::clamp(-3 + 0.25 * std::clamp(-0.5 + 32.0 * (i + 0.5) / kSteps, 0.0, 31.0), 0.0, 4.0);
            depth -= std::log1p(-0.2 * q / 4) * 32 / kSteps;
        }
        const double alpha = -std::expm1(-depth), speed = 40 + 0.5 * y;
        EXPECT_NEAR(image.at(x, 10).a, alpha, 2e-3);
        EXPECT_NEAR(image.at(x, 10).r, alpha * linearFromDisplay((speed - 40) / 10), 2e-3);
        EXPECT_NEAR(image.layers[std::size_t(10 * 20 + x)].driver, speed, 1e-2);
    }
}

TEST(TwoScalars, OneScalarTwiceIsOneScalar)
{
    const auto texture = boxGrid("density", boxOf(24, 24, 24), scattered), driver = ramp("magnitude", 0, 0.02f, 0.01f);
    TextureVolume once(*texture, *driver), twice(*texture, *driver);
    twice.addColors(*texture, *driver);
    const Camera camera = cameraAlong(once, {1, 0.4, -0.3}, 200, 12, {40, 40});
    EXPECT_LT(difference(castRays(once, fullLook(), camera, {}), castRays(twice, fullLook(), camera, {})), 2e-3f);
}

TEST(TwoScalars, NumbersThatAreNotFiniteTakeTheirNeighboursColour)
{
    const auto texture = ramp("density", 1, 0, 0), colors = ramp("speed", 5, 0, 0);
    colors->tree().setValueOn(Coord(12), std::numeric_limits<float>::quiet_NaN());
    TextureVolume volume(*texture, *texture);
    volume.addColors(*texture, *colors);
    for (std::size_t leaf = 0; leaf < volume.leafCount(); ++leaf) {
        const float* const values = volume.colors()->values(leaf);
        for (int i = 0; i < ScalarLeaf::kSize; ++i)
            EXPECT_TRUE(values[i] == 5 || values[i] == 0) << values[i];
    }
    const auto apart = ramp("speed", 5, 0, 0);
    apart->setTransform(openvdb::math::Transform::createLinearTransform(2));
    EXPECT_THROW(volume.addColors(*texture, *apart), InputError);
}

TEST(TwoScalars, AutomaticRangesAreOfEachScalar)
{
    const auto texture = boxGrid("density", boxOf(24, 24, 24), scattered);
    TextureVolume volume(*texture, *ramp("q", -10, 1, 0));
    volume.addColors(*texture, *ramp("speed", 100, 0, 1));
    const Look look = chooseLook({}, volume);
    EXPECT_NEAR(look.transfer.range()[0], 100, 1);
    EXPECT_NEAR(look.transfer.range()[1], 123, 1);
    EXPECT_EQ(look.transfer.opacityRange()[0], 0); // of both signs: negative values are transparent
    EXPECT_NEAR(look.transfer.opacityRange()[1], 13, 1);
    EXPECT_FALSE(look.transfer.contributes(-10, -1));
}

} // namespace
} // namespace vdblic
