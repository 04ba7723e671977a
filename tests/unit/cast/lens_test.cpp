#include "vdblic/cast/pixel_rays.h"

#include "cast/test_scene.h"
#include "vdblic/cast/solid.h"
#include "vdblic/cast/supersampling.h"

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace vdblic {
namespace {

using openvdb::Coord;

constexpr double kFocus = 100, kAperture = 12;

Camera lensCamera(Projection projection, const TextureVolume& volume, double aperture, double focus = kFocus)
{
    const glm::dvec3 eye(-80, 15, 15);
    CameraParams params{.projection = projection,
                        .eye = eye,
                        .target = eye + glm::dvec3(focus, 0, 0),
                        .fieldOfView = 30,
                        .aperture = aperture};
    if (projection == Projection::kOrthographic) params.viewHeight = 2 * kFocus * std::tan(glm::radians(15.0));
    return Camera(params, volume.corners(), {120, 120});
}

/// A plate of the thickness of a voxel at x = 20, of y below 15.
openvdb::FloatGrid::Ptr plateGrid()
{
    return boxGrid("density", openvdb::CoordBBox({20, -60, -60}, {20, 14, 90}), [](const Coord&) { return 1.0f; });
}

TEST(Lens, RaysOfAPixelMeetInTheFocalPlaneAndFillACircleElsewhere)
{
    const auto grid = plateGrid();
    const TextureVolume volume(*grid, *grid);
    for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
        const Camera camera = lensCamera(projection, volume, kAperture);
        const PixelRays middle(lensCamera(projection, volume, 0), 0);
        for (const glm::ivec2 pixel : {glm::ivec2(5, 9), glm::ivec2(60, 60), glm::ivec2(100, 31)}) {
            const auto [origin, direction] = middle.at(pixel.x, pixel.y);
            constexpr int kRays = 400;
            for (const double depth : {kFocus, 0.0, 40.0, 250.0}) {
                const double radius = kAperture / 2 * std::abs(1 - depth / kFocus);
                double squares = 0, most = 0;
                glm::dvec3 mean(0);
                for (int ray = 0; ray < kRays; ++ray) {
                    const auto line = PixelRays(camera, ray).at(pixel.x, pixel.y);
                    const glm::dvec3 aside = line.origin + line.direction * depth - origin - direction * depth;
                    EXPECT_NEAR(aside.x, 0, 1e-9); // in the plane of that depth
                    mean += aside / double(kRays);
                    squares += glm::dot(aside, aside) / kRays;
                    most = std::max(most, glm::length(aside));
                }
                EXPECT_LE(most, radius + 1e-9);
                EXPECT_GE(most, 0.97 * radius);
                EXPECT_NEAR(glm::length(mean), 0, 0.01 * radius + 1e-9);
                EXPECT_NEAR(squares, radius * radius / 2, 0.01 * radius * radius + 1e-9);
            }
        }
    }
}

TEST(Lens, AnEdgeIsSharpInTheFocalPlaneAndElsewhereAsWideAsTheCircle)
{
    const auto grid = plateGrid();
    const TextureVolume volume(*grid, *grid);
    const Look look = plainLook(1);
    // Two planes that cut nothing visible: cuts take another way through the rays' setup.
    const ClipParams clip{.planes = {{{10, 0, 0}, {1, 0.1, 0}}, {{0, 0, 60}, {0, 0.2, -1}}}};
    for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
        const auto across = [&](double aperture, double focus) {
            const Camera camera = lensCamera(projection, volume, aperture, focus);
            const Image image = castSamples(volume, look, camera, {.step = 0.25, .clip = clip}, 300);
            std::vector<double> alphas(120);
            for (int x = 0; x < 120; ++x)
                alphas[std::size_t(x)] = image.at(x, 60).a;
            return alphas;
        };
        const std::vector<double> pinhole = across(0, kFocus), sharp = across(kAperture, kFocus);
        for (std::size_t x = 0; x < 120; ++x)
            EXPECT_NEAR(sharp[x], pinhole[x], 0.15) << x; // the plate is as thick as a voxel
        // Focus at half the plate's distance: the circle's radius there is that of the lens.
        const std::vector<double> wide = across(kAperture, kFocus / 2);
        const double perPixel = 2 * kFocus * std::tan(glm::radians(15.0)) / 120, radius = kAperture / 2;
        const bool rises = pinhole[119] > pinhole[0];
        for (std::size_t x = 0; x < 120; ++x) {
            const double distance = (double(x) + 0.5 - 60) * perPixel - 0.5 * (rises ? 1 : -1);
            // The part of the circle on the plate's side of the edge.
            const double t = std::clamp((rises ? distance : -distance) / radius, -1.0, 1.0);
            const double part = 0.5 + (t * std::sqrt(1 - t * t) + std::asin(t)) / std::numbers::pi;
            EXPECT_NEAR(wide[x], part, 0.05) << x;
        }
    }
}

TEST(Lens, ASmallBodyOutOfFocusIsACircle)
{
    const auto grid = boxGrid("density", boxOf(32, 32, 32), [](const Coord&) { return 1.0f; });
    const TextureVolume volume(*grid, *grid);
    const Look look = plainLook(1e-6);
    const Solid point{openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(1, openvdb::Vec3f(20, 15, 15), 0.25f)};
    Solid body{point.levelSet};
    body.levelSet->setTransform(openvdb::math::Transform::createLinearTransform());
    const double scale = 4; // of voxels of the level set
    for (auto value = body.levelSet->beginValueAll(); value; ++value)
        value.setValue(*value * float(scale));
    body.levelSet->setGridClass(openvdb::GRID_LEVEL_SET);
    body.worldToIndex = glm::dmat4(scale);
    body.worldToIndex[3][3] = 1;
    const Camera camera = lensCamera(Projection::kPerspective, volume, kAperture, kFocus / 2);
    const Image image = castSamples(volume, look, camera, {}, 200, {.solid = &body, .solidColor = glm::vec3(1)});
    const double perPixel = 2 * kFocus * std::tan(glm::radians(15.0)) / 120;
    double farthest = 0, sum = 0;
    for (int y = 0; y < 120; ++y) {
        for (int x = 0; x < 120; ++x) {
            const double alpha = image.at(x, y).a;
            if (alpha < 0.004) continue;
            farthest = std::max(farthest, perPixel * glm::length(glm::dvec2(x + 0.5, y + 0.5) - 60.0));
            sum += alpha * perPixel * perPixel;
        }
    }
    EXPECT_NEAR(farthest, kAperture / 2 + 1, 1);
    EXPECT_NEAR(sum, std::numbers::pi, 0.3); // the light of the sphere's disc
}

TEST(Lens, EveryPixelHasAllRays)
{
    const auto grid = boxGrid("density", boxOf(32, 32, 32), [](const Coord&) { return 0.5f; });
    const TextureVolume volume(*grid, *grid);
    const auto samples = [&](double aperture, int rays) {
        const Camera camera = lensCamera(Projection::kPerspective, volume, aperture);
        return double(
            castSamples(volume, plainLook(0.01), camera, {.layers = true}, rays).layers[60 * 120 + 60].samples);
    };
    EXPECT_NEAR(samples(0, 12), samples(0, 2), 1);
    EXPECT_NEAR(samples(1, 12), 6 * samples(1, 2), 12);
}

} // namespace
} // namespace vdblic
