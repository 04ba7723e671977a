#include "cast/test_scene.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <cmath>

namespace vdblic {
namespace {

using openvdb::Coord;

constexpr int kRodLength = 40;

/// A box along x whose texture rises along x; the driver is the same everywhere. Voxels are 0.5 x 2 x 1.
TextureVolume slab(const openvdb::Mat4d& rotation = openvdb::Mat4d::identity())
{
    const auto texture =
        boxGrid("density", boxOf(kRodLength, 9, 9), [](const Coord& c) { return float(c.x()) / (kRodLength - 1); });
    const auto driver = boxGrid("magnitude", boxOf(kRodLength, 9, 9), [](const Coord&) { return 7.5f; });
    const openvdb::Mat4d matrix = openvdb::math::scale<openvdb::Mat4d>(openvdb::Vec3d(0.5, 2, 1)) * rotation;
    for (const auto& grid : {texture, driver})
        grid->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    return {*texture, *driver};
}

const RayCastParams kFine{.step = 0.02, .leastTransmittance = 0, .layers = true};

TEST(ImageLayers, HoldTheMeansOfAUniformMedium)
{
    const TextureVolume volume = slab();
    constexpr double kOpacity = 0.05;
    const Camera camera = cameraAlong(volume, {1, 0, 0}, 100, 0.5, {3, 3});
    const Image image = castRays(volume, plainLook(kOpacity), camera, kFine);
    const PixelLayers& middle = image.layers.at(4);

    // The mean of x weighted by exp(−kx) over the box.
    const double k = -std::log1p(-kOpacity), through = std::exp(-k * kRodLength);
    const double mean = 1 / k - kRodLength * through / (1 - through); // voxels behind the front
    EXPECT_NEAR(middle.depth, 100 - 0.5 * kRodLength / 2 + 0.5 * mean, 0.02);
    EXPECT_NEAR(middle.texture, (mean - 0.5) / (kRodLength - 1), 1e-3);
    EXPECT_NEAR(middle.driver, 7.5, 1e-4);
    EXPECT_NEAR(glm::distance(middle.normal, glm::vec3(-1, 0, 0)), 0, 1e-5);
    EXPECT_NEAR(middle.samples, kRodLength / kFine.step, 2);
}

TEST(ImageLayers, DepthIsThatOfTheFirstOpaqueSurfaceAlongTheViewAxis)
{
    // A plane across the view has one depth in all pixels, however wide the angle.
    const TextureVolume volume = slab();
    const Camera camera = cameraAlong(volume, {1, 0, 0}, 14, 40, {9, 9});
    const Image image = castRays(volume, plainLook(1), camera, kFine);
    for (const PixelLayers& pixel : image.layers)
        EXPECT_NEAR(pixel.depth, 14 - 0.5 * kRodLength / 2, 0.05);
}

TEST(ImageLayers, NormalsAreInWorldSpaceAndTowardsTheEye)
{
    openvdb::Mat4d rotation = openvdb::Mat4d::identity();
    rotation.postRotate(openvdb::math::Z_AXIS, 0.6);
    const TextureVolume volume = slab(rotation);
    // The gradient of x in index space: a step along the first index axis crosses it, steps along the others do not.
    const glm::dvec3 normal = glm::normalize(glm::transpose(glm::dmat3(volume.worldToIndex())) * glm::dvec3(1, 0, 0));
    for (const glm::dvec3& view : {glm::dvec3(0.9, 0.3, 0.2), glm::dvec3(-0.9, -0.3, 0.2)}) {
        const Camera camera = cameraAlong(volume, glm::normalize(view), 90, 1, {1, 1});
        const PixelLayers pixel = castRays(volume, plainLook(0.3), camera, kFine).layers.at(0);
        const glm::dvec3 expected = glm::dot(normal, view) > 0 ? -normal : normal;
        EXPECT_NEAR(glm::distance(glm::dvec3(pixel.normal), expected), 0, 2e-3);
    }
}

TEST(ImageLayers, AreEmptyBesideTheVolume)
{
    const TextureVolume volume = slab();
    const Camera camera = cameraAlong(volume, {1, 0, 0}, 100, 60, {9, 9});
    const PixelLayers corner = castRays(volume, plainLook(1), camera, kFine).layers.at(0);
    EXPECT_TRUE(std::isinf(corner.depth));
    EXPECT_EQ(corner.normal, glm::vec3(0));
    EXPECT_EQ(corner.samples, 0);
}

TEST(ImageLayers, DoNotChangeThePicture)
{
    const auto grid = boxGrid("density", boxOf(40, 30, 20), scattered);
    const TextureVolume volume(*grid, *grid);
    const Camera camera({}, volume.corners(), {60, 40});
    const Image plain = castRays(volume, fullLook(), camera, {});
    const Image layered = castRays(volume, fullLook(), camera, {.layers = true});
    EXPECT_TRUE(plain.layers.empty());
    EXPECT_EQ(plain.pixels, layered.pixels);
}

} // namespace
} // namespace vdblic
