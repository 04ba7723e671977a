#include "vdblic/cast/supersampling.h"

#include "cast/test_scene.h"
#include "vdblic/cast/ray_setup.h"
#include "vdblic/core/reporter.h"
#include "vdblic/volume/visible_space.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stop_token>

namespace vdblic {
namespace {

using openvdb::Coord;

/// A plate that covers the left half of the picture and a third of the next pixel's column.
Image plate(int samples)
{
    const auto grid = boxGrid("density", boxOf(30, 3, 60), [](const Coord&) { return 0.5f; });
    const TextureVolume volume(*grid, *grid);
    // Nine voxels per pixel; the plate ends at 29.5, a third of the way from 26.5 to 35.5.
    const glm::dvec3 target(26.5, 1, 29.5);
    const Camera camera({.projection = Projection::kOrthographic,
                         .eye = target - glm::dvec3(0, 50, 0),
                         .target = target,
                         .viewHeight = 36},
                        volume.corners(), {4, 4});
    return castSamples(volume, plainLook(1), camera, {.step = 0.05, .layers = true}, samples);
}

TEST(Supersampling, TakesTheMeanOverThePixel)
{
    const Image one = plate(1), many = plate(300);
    EXPECT_NEAR(one.at(1, 1).a, 1, 3e-3);
    EXPECT_NEAR(many.at(1, 1).a, 1, 3e-3);
    EXPECT_EQ(one.at(2, 1).a, 0); // its centre is beside the plate
    EXPECT_NEAR(many.at(2, 1).a, 1 / 3.0, 0.01);
    EXPECT_NEAR(many.at(2, 1).r, many.at(2, 1).a, 1e-5);
    EXPECT_EQ(many.at(3, 1).a, 0);
}

TEST(Supersampling, MeansOfLayersAreOfWhatIsSeen)
{
    const PixelLayers whole = plate(1).layers.at(1), part = plate(300).layers.at(4 + 2);
    EXPECT_NEAR(part.depth, whole.depth, 0.05);
    EXPECT_NEAR(part.texture, 0.5, 1e-4);
    EXPECT_GT(part.samples, whole.samples);
    EXPECT_TRUE(std::isinf(plate(5).layers.at(3).depth));
}

TEST(Supersampling, AStopKeepsTheRaysSoFar)
{
    const auto grid = boxGrid("density", boxOf(20, 20, 20), [](const Coord& at) { return 0.05f * float(at.x()); });
    const TextureVolume volume(*grid, *grid);
    const Look look = plainLook(0.1);
    const Camera camera({}, volume.corners(), {16, 16});
    const VisibleSpace visible(volume, look);
    SampleSum sum(castOf(volume, look, visible, {.layers = true}), camera);
    sum.add();
    std::stop_source stopped;
    stopped.request_stop();
    EXPECT_THROW(sum.add(stopped.get_token()), Stopped);
    EXPECT_EQ(sum.count(), 1);
    sum.add();
    const Image two = castSamples(volume, look, camera, {.layers = true}, 2, {});
    EXPECT_EQ(sum.mean().pixels, two.pixels);
    EXPECT_EQ(sum.mean().layers.at(100).depth, two.layers.at(100).depth);
    // The third ray is that of some pixels alone, also after a stop.
    EXPECT_THROW(sum.add(stopped.get_token()), Stopped);
    EXPECT_EQ(sum.mean().pixels, two.pixels);
    sum.add();
    EXPECT_EQ(sum.mean().pixels, castSamples(volume, look, camera, {.layers = true}, 3, {}).pixels);
}

TEST(Supersampling, FurtherRaysAreThoseOfPixelsThatDiffer)
{
    // The plate fills two columns of pixels and a third of the next one, whose two rays both miss it; a neighbour
    // tells.
    constexpr int kRays = 300;
    const Image two = plate(2), many = plate(kRays);
    const auto raysOf = [&](int x) {
        const std::size_t pixel = 4 + std::size_t(x);
        return many.layers[pixel].samples / (two.layers[pixel].samples / 2);
    };
    EXPECT_NEAR(raysOf(0), 2, 0.05);
    EXPECT_NEAR(raysOf(1), kRays, 3);
    EXPECT_EQ(many.at(0, 1), two.at(0, 1));
    EXPECT_NEAR(many.at(2, 1).a, 1 / 3.0, 0.01);
}

TEST(Supersampling, ShiftsOfAPixelsRaysAreSpreadEvenly)
{
    for (const int count : {2, 3, 5, 8, 13, 50}) {
        std::vector<float> shifts;
        shifts.reserve(std::size_t(count));
        for (int ray = 0; ray < count; ++ray)
            shifts.push_back(sampleShift(17, 5, ray));
        std::sort(shifts.begin(), shifts.end());
        for (int i = 1; i < count; ++i) {
            EXPECT_GT(shifts[i] - shifts[i - 1], 0.5f / float(count)) << count;
            EXPECT_LT(shifts[i] - shifts[i - 1], 2 / float(count)) << count;
        }
    }
}

TEST(Supersampling, OneSampleIsThePlainPicture)
{
    const auto grid = boxGrid("density", boxOf(20, 20, 20), scattered);
    const TextureVolume volume(*grid, *grid);
    const Camera camera({}, volume.corners(), {30, 20});
    EXPECT_EQ(castSamples(volume, fullLook(), camera, {}, 1).pixels, castRays(volume, fullLook(), camera, {}).pixels);
}

} // namespace
} // namespace vdblic
