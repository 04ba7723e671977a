#include "vdblic/cast/ray_caster.h"

#include "cast/test_scene.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <cmath>

namespace vdblic {
namespace {

using openvdb::Coord;

TEST(CutsAndLooks, ClipPlanesCutToThePixel)
{
    const auto grid = boxGrid("density", boxOf(40, 40, 40), [](const Coord&) { return 1.0f; });
    const TextureVolume volume(*grid, *grid);
    const Camera camera = cameraAlong(volume, {1, 0, 0}, 1e5, 0.02, {200, 200});
    const Look look = plainLook(0.5);
    // A plane seen edge-on: the rest of the volume begins in the pixel where the plane is projected.
    const ClipPlane slanted{{19.5, 22.3, 19.5}, {0, 1, 0.25}};
    const Image cut = castRays(volume, look, camera, {.clip = {.planes = {slanted}}});
    const Image whole = castRays(volume, look, camera, {});
    for (int y = 0; y < 200; ++y) {
        for (int x = 0; x < 200; ++x) {
            const Ray ray = camera.ray({x + 0.5, y + 0.5});
            const glm::dvec3 point = ray.origin + ray.direction * ((19.5 - ray.origin.x) / ray.direction.x);
            const double above = glm::dot(point - slanted.point, slanted.normal);
            if (std::abs(above) < 0.01) continue;
            EXPECT_EQ(cut.at(x, y).a > 0, above > 0 && whole.at(x, y).a > 0) << x << " " << y;
        }
    }
    // Face-on, the optical depth is that behind the plane. Two planes and a box cut from both sides.
    const ClipPlane front{{10.25, 0, 0}, {3, 0, 0}}, back{{30, 0, 0}, {-1, 0, 0}};
    const auto depth = [&](const ClipParams& clip) {
        const Image image = castRays(volume, plainLook(0.05), camera, {.leastTransmittance = 0, .clip = clip});
        return std::log(1 - double(image.at(100, 100).a)) / std::log(0.95);
    };
    EXPECT_NEAR(depth({.planes = {front}}), 39.5 - 10.25, 2e-3);
    EXPECT_NEAR(depth({.planes = {front, back}}), 30 - 10.25, 2e-3);
    EXPECT_NEAR(depth({.box = std::array{glm::dvec3(12.5, 0, 0), glm::dvec3(14, 39, 39)}}), 1.5, 2e-3);
    EXPECT_EQ(depth({.planes = {{{50, 0, 0}, {1, 0, 0}}}}), 0);
}

TEST(CutsAndLooks, CapsAreLitAsThePlaneThatCuts)
{
    // Opaque, so that only the cap is seen; random inside, so that gradients give no usable normals.
    const auto grid = boxGrid("density", boxOf(30, 30, 30), [](const Coord& c) { return 0.6f + 0.4f * scattered(c); });
    const TextureVolume volume(*grid, *grid);
    Look look{TransferFunction({.colorMap = "gray", .opacity = {{0, 1}}, .range = std::array{-2.0, -1.0}}),
              {0, 1, 0, 0},
              {.ambient = 0.25f, .diffuse = 0.5f, .specular = 0}};
    const Camera camera = cameraAlong(volume, {1, 0, 0}, 1e5, 0.005, {20, 20});
    for (const glm::dvec3& normal : {glm::dvec3(1, 0, 0), glm::dvec3(1, 1, 0), glm::dvec3(2, -1, 1)}) {
        const ClipParams clip{.planes = {{glm::dvec3(14.5), normal}}};
        const double cosine = normal.x / glm::length(normal);
        EXPECT_NEAR(castRays(volume, look, camera, {.step = 0.1, .clip = clip}).at(10, 10).r, 0.25 + 0.5 * cosine,
                    0.03);
        look.shading.headLight = 0;
        look.shading.lights = {{.direction = {-1, -1, 0}, .intensity = 2}};
        const double lit = std::max(0.0, glm::dot(-normal, glm::dvec3(-1, -1, 0)) / glm::length(normal) / std::sqrt(2));
        EXPECT_NEAR(castRays(volume, look, camera, {.step = 0.1, .clip = clip}).at(10, 10).r, 0.25 + lit, 0.05);
        look.shading.headLight = 1;
        look.shading.lights.clear();
    }
}

TEST(CutsAndLooks, HalosHideOnlyWhatIsBehindStreaks)
{
    // One streak across the view. Its edge-on flanks have the background's colour, its middle does not.
    const auto grid = boxGrid("density", boxOf(21, 21, 21), [](const Coord& c) {
        const double square = (c.x() - 10) * (c.x() - 10) + (c.y() - 10) * (c.y() - 10);
        return float(std::exp(-square / 18));
    });
    const TextureVolume volume(*grid, *grid);
    Look look{TransferFunction({.colorMap = "gray", .opacity = {{0, 0.9}}, .range = std::array{-2.0, -1.0}}),
              {0, 1, 1, 0},
              {.model = ShadingModel::kNone}};
    look.background.color = {0, 1, 0};
    const Camera camera = cameraAlong(volume, {1, 0, 0}, 1e4, 0.12, {101, 101});
    const Image without = castRays(volume, look, camera, {});
    look.halo.strength = 2;
    const Image with = castRays(volume, look, camera, {});
    EXPECT_LT(std::abs(with.at(50, 50).a - without.at(50, 50).a), 0.01f);
    EXPECT_LT(with.at(50, 50).g - with.at(50, 50).r, 0.03f);
    float most = 0;
    for (int x = 0; x < 101; ++x) {
        EXPECT_GE(with.at(x, 50).a, without.at(x, 50).a - 1e-3f);
        most = std::max(most, with.at(x, 50).g - with.at(x, 50).r);
    }
    EXPECT_GT(most, 0.3f);
}

TEST(CutsAndLooks, DepthCueFadesTheFarEndToTheBackground)
{
    const auto grid = boxGrid("density", boxOf(40, 10, 10), [](const Coord&) { return 1.0f; });
    const TextureVolume volume(*grid, *grid);
    Look look = plainLook(0.999);
    look.background.color = {0, 0, 1};
    look.depthCue = 0.5f;
    const Camera camera = cameraAlong(volume, {1, 0, 0}, 1e4, 0.01, {9, 9});
    const auto red = [&](double x) {
        return castRays(volume, look, camera, {.step = 0.1, .clip = {.planes = {{{x, 0, 0}, {1, 0, 0}}}}}).at(4, 4).r;
    };
    EXPECT_NEAR(red(-0.5), 1, 0.01);
    EXPECT_NEAR(red(19.5), 0.75, 0.01);
    EXPECT_NEAR(red(39), 0.5, 0.02);
}

TEST(CutsAndLooks, LinesAreBrightestSeenFromTheSide)
{
    const auto grid = boxGrid("density", boxOf(24, 24, 24), [](const Coord& c) {
        return float(0.5 + 0.25 * std::sin(1.1 * c.x()) + 0.25 * std::cos(0.9 * c.y())); // lines along z
    });
    TextureVolume volume(*grid, *grid);
    volume.addLines();
    Look look = plainLook(0.5);
    look.shading = {.model = ShadingModel::kLine, .ambient = 0, .diffuse = 1, .specular = 0};
    const auto brightness = [&](const glm::dvec3& direction) {
        return castRays(volume, look, cameraAlong(volume, direction, 1e4, 0.01, {9, 9}), {}).at(4, 4).r;
    };
    EXPECT_GT(brightness({1, 0.3, 0}), 0.5f);
    EXPECT_LT(brightness({0.02, 0.02, 1}), brightness({1, 0.3, 0}) / 2);
}

} // namespace
} // namespace vdblic
