#include "vdblic/cast/ground.h"

#include "cast/test_scene.h"
#include "vdblic/cast/extinction_grid.h"
#include "vdblic/cast/solid.h"
#include "vdblic/cast/supersampling.h"
#include "vdblic/core/exchange.h"

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <cmath>
#include <cstddef>

namespace vdblic {
namespace {

using openvdb::Coord;

const glm::dvec3 kUp(0, 0, 1);

class OnGround : public testing::Test {
  protected:
    static GroundPlane below(const TextureVolume& volume, const Solid* solid = nullptr)
    {
        return groundPlane(GroundSide::kBelow, kUp, volume.corners(), solid);
    }
    OneProcess mAlone;
};

TEST_F(OnGround, TheShadowOfABlockLiesWhereGeometrySays)
{
    // A block of 20³ voxels, its lower face 22 voxels above the ground, in a medium as good as invisible.
    const auto texture = boxGrid("density", boxOf(64, 64, 64), [](const Coord&) { return 1.0f; });
    for (auto voxel = openvdb::CoordBBox({22, 22, 22}, {41, 41, 41}).begin(); voxel; ++voxel)
        texture->tree().setValueOff(*voxel);
    const TextureVolume volume(*texture, *texture);
    const ExtinctionGrid visible(volume, plainLook(1e-6), mAlone);
    const Solid block = makeSolid("domain", *texture, glm::dvec3(1), 1);
    const GroundPlane plane = below(volume, &block);
    EXPECT_NEAR(plane.height, -0.5, 1e-9);
    const ShadowCasters casters{visible, volume, {}, &block};
    const GroundLight lit(plane, casters, {0.5, 0, 1}), open(plane, casters, {0.5, 0, -1});
    const auto shadow = [&](double x, double y) { return (open.at({x, y}) - lit.at({x, y})) / 0.6; };
    // Moved by half the height, away from the light: from 21.5 − 42 / 2 to 41.5 − 22 / 2 along x.
    EXPECT_NEAR(shadow(15, 31), 1, 0.01);
    for (const double x : {-8.0, 38.0})
        EXPECT_NEAR(shadow(x, 31), 0, 0.01) << x;
    EXPECT_NEAR(shadow(15, 12), 0, 0.01);
    EXPECT_NEAR(shadow(0.5, 31), 0.5, 0.2);
    EXPECT_NEAR(shadow(30.5, 31), 0.5, 0.25);
    EXPECT_NEAR(shadow(15, 41.5), 0.5, 0.2);
}

TEST_F(OnGround, TransmittanceOfASlabIsAnalytic)
{
    const auto texture = boxGrid("density", boxOf(64, 64, 24), [](const Coord&) { return 1.0f; });
    const TextureVolume volume(*texture, *texture);
    const double opacity = 0.03;
    const ExtinctionGrid visible(volume, plainLook(opacity), mAlone);
    const GroundPlane plane = below(volume);
    const auto shadow = [&](std::span<const ClipPlane> cuts) {
        const ShadowCasters casters{visible, volume, cuts};
        const glm::dvec2 middle(31.5);
        return (GroundLight(plane, casters, {0, 0, -1}).at(middle) - GroundLight(plane, casters, kUp).at(middle)) / 0.6;
    };
    EXPECT_NEAR(shadow({}), 1 - std::pow(1 - opacity, 24), 0.01);
    const std::vector<ClipPlane> cuts{{{0, 0, 9.5}, {0, 0, -1}}}; // ten voxels are left
    EXPECT_NEAR(shadow(cuts), 1 - std::pow(1 - opacity, 10), 0.01);
}

TEST_F(OnGround, ThinSheetsBehindEmptySpaceCastShadows)
{
    const double opacity = 0.2;
    for (int height = 17; height < 60; height += 3) {
        const auto texture = boxGrid("density", boxOf(64, 64, height + 1), [](const Coord&) { return 1.0f; });
        for (auto voxel = openvdb::CoordBBox({0, 0, 1}, {63, 63, height - 1}).begin(); voxel; ++voxel)
            texture->tree().setValueOff(*voxel);
        const TextureVolume volume(*texture, *texture);
        const ExtinctionGrid visible(volume, plainLook(opacity), mAlone);
        const GroundPlane plane = below(volume);
        const ShadowCasters casters{visible, volume, {}};
        const auto light = [&](const glm::dvec3& towards) {
            return double(GroundLight(plane, casters, towards).at({31.5, 31.5}));
        };
        const double shadow = (light({0, 0, -1}) - light(kUp)) / 0.6;
        EXPECT_NEAR(shadow, 1 - (1 - opacity) * (1 - opacity), 0.01) << height;
    }
}

TEST_F(OnGround, OcclusionDarkensWhereABodyMeetsIt)
{
    const auto texture = boxGrid("density", boxOf(64, 64, 64), [](const Coord&) { return 1.0f; });
    for (auto voxel = openvdb::CoordBBox({22, 22, 0}, {41, 41, 41}).begin(); voxel; ++voxel)
        texture->tree().setValueOff(*voxel);
    const TextureVolume volume(*texture, *texture);
    const ExtinctionGrid visible(volume, plainLook(1e-6), mAlone);
    const Solid block = makeSolid("domain", *texture, glm::dvec3(1), 1);
    const GroundLight light(below(volume, &block), {visible, volume, {}, &block}, {0, 0, -1});
    float before = 0;
    for (const double distance : {1.5, 4.0, 8.0, 16.0}) {
        const float there = light.at({41.5 + distance, 31});
        EXPECT_GT(there, before + 0.01f) << distance;
        before = there;
    }
    // A high wall takes less than half of the light from everywhere, as its far parts count less.
    EXPECT_NEAR(light.at({43, 31}), 1 - 0.4 * 0.35, 0.05);
    EXPECT_NEAR(light.at({41.5 + 45, 31}), 1, 1e-3);
}

TEST_F(OnGround, LiesBelowOrAtAWall)
{
    const auto texture = boxGrid("density", boxOf(20, 30, 40), [](const Coord&) { return 1.0f; });
    const TextureVolume volume(*texture, *texture, {1, 1, 2});
    const Solid sphere{openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(6, openvdb::Vec3f(10, 10, -20), 1)};
    EXPECT_NEAR(below(volume).height, -1, 1e-6);
    EXPECT_NEAR(below(volume, &sphere).height, -26, 0.6);
    const GroundPlane wall = groundPlane(GroundSide::kHighY, kUp, volume.corners(), nullptr);
    EXPECT_EQ(wall.normal, glm::dvec3(0, -1, 0));
    EXPECT_NEAR(wall.height, -29.5, 1e-6);
    const GroundPlane tilted = groundPlane(GroundSide::kBelow, {1, 0, 1}, volume.corners(), nullptr);
    EXPECT_NEAR(tilted.height, -1.5 / std::sqrt(2), 1e-6);
    EXPECT_NEAR(glm::dot(tilted.axes[0], tilted.normal), 0, 1e-12);
    EXPECT_NEAR(glm::dot(tilted.axes[1], tilted.axes[0]), 0, 1e-12);
}

TEST_F(OnGround, FadesOutAndIsSeenFromAboveAlone)
{
    const auto texture = boxGrid("density", boxOf(32, 32, 32), [](const Coord&) { return 1.0f; });
    const TextureVolume volume(*texture, *texture);
    const Look look = plainLook(1e-6);
    const ExtinctionGrid visible(volume, look, mAlone);
    const GroundPlane plane = below(volume);
    const Ground ground(plane, {visible, volume}, kUp);
    const auto seen = [&](const glm::dvec3& eye, bool hasGround) {
        const Camera camera(
            {.eye = eye, .target = glm::dvec3(15.5, 15.5, -0.5), .up = glm::dvec3(0, 1, 0), .fieldOfView = 40},
            volume.corners(), {160, 160});
        return castSamples(volume, look, camera, {.layers = true}, 1, {.ground = hasGround ? &ground : nullptr});
    };
    const Image above = seen({15.5, 15.5, 199.5}, true);
    const double perPixel = 2 * 200 * std::tan(glm::radians(20.0)) / 160;
    for (const int x : {80, 95, 110, 115, 122}) {
        const double expected = plane.alpha(plane.middle + glm::dvec2((x + 0.5 - 80) * perPixel, 0));
        EXPECT_NEAR(above.at(x, 80).a, expected, 1e-3) << x;
        EXPECT_NEAR(above.layers[std::size_t(80 * 160 + x)].depth, 200, 0.5) << x;
    }
    EXPECT_EQ(above.at(80, 80).a, 1);
    EXPECT_EQ(above.at(159, 80).a, 0);
    const glm::dvec3 under(15.5, 20, -200);
    EXPECT_EQ(seen(under, true).pixels, seen(under, false).pixels);
}

} // namespace
} // namespace vdblic
