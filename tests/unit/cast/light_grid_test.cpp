#include "vdblic/cast/light_grid.h"

#include "cast/test_scene.h"
#include "vdblic/cast/ray_caster.h"
#include "vdblic/volume/visible_space.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace vdblic {
namespace {

using openvdb::Coord;

TEST(Shadows, TransmittanceOfASlabIsAnalytic)
{
    const auto texture = boxGrid("density", boxOf(64, 48, 40), [](const Coord&) { return 1.0f; });
    const TextureVolume volume(*texture, *texture);
    Look look = plainLook(0.02);
    const double extinction = -std::log1p(-0.02);
    for (const glm::dvec3& light : {glm::dvec3(1, 0, 0), glm::dvec3(0, 0, -3), glm::dvec3(0.2, 0.9, 0.1)}) {
        look.shadows = 1;
        const LightGrid grid = lightIn(volume, look, light);
        look.shadows = 0.5;
        const LightGrid half = lightIn(volume, look, light);
        const glm::dvec3 unit = glm::normalize(light);
        for (const glm::dvec3& at : {glm::dvec3(20, 20, 20), glm::dvec3(31.3, 12.2, 9), glm::dvec3(50, 40, 30)}) {
            double way = 1e9; // to the face where the light enters
            for (int axis = 0; axis < 3; ++axis) {
                const double size[] = {63.5, 47.5, 39.5};
                if (unit[axis] != 0)
                    way = std::min(way, ((unit[axis] > 0 ? size[axis] : -0.5) - at[axis]) / unit[axis]);
            }
            EXPECT_NEAR(grid.at(at), std::exp(-extinction * way), 0.01) << at.x << " " << light.x;
            EXPECT_NEAR(half.at(at), 0.5 + 0.5 * std::exp(-extinction * way), 0.005);
        }
    }
}

TEST(Occlusion, LightsWhatIsOpenAndDarkensWhatIsClosedIn)
{
    // A block with a pit from above.
    const auto texture = boxGrid("density", boxOf(64, 64, 48), [](const Coord& c) {
        const bool isPit = std::abs(c.x() - 32) < 5 && std::abs(c.y() - 32) < 5 && c.z() > 20;
        return c.z() > 39 || isPit ? 0.0f : 1.0f;
    });
    const TextureVolume volume(*texture, *texture);
    Look look = fullLook();
    look.texture = {0, 1};
    look.occlusion = 1;
    const LightGrid grid = lightIn(volume, look, {0, 0, 1});
    const float top = grid.at({12, 32, 40}), bottom = grid.at({32, 32, 21}), inside = grid.at({12, 32, 20});
    EXPECT_GT(top, 1.1f);
    EXPECT_LT(bottom, 0.7f * top);
    EXPECT_LT(inside, bottom);
    look.occlusion = 0.5;
    EXPECT_NEAR(lightIn(volume, look, {0, 0, 1}).at({12, 32, 40}), 0.5f + 0.5f * top, 1e-5f);
}

TEST(Occlusion, ChangesNothingWhereAllIsAlike)
{
    const auto texture = boxGrid("density", boxOf(40, 40, 40), [](const Coord&) { return 1.0f; });
    const TextureVolume volume(*texture, *texture);
    Look look = plainLook(1e-6); // nothing occludes
    look.occlusion = 1;
    const LightGrid grid = lightIn(volume, look, {0, 0, 1});
    EXPECT_NEAR(grid.at({20, 20, 20}), 1, 1e-3);
    EXPECT_NEAR(grid.at({1, 1, 1}), 1, 1e-3);
}

TEST(Shadows, DarkenSamplesByTheirStrength)
{
    // Lit from behind: the front of a thick medium is in shadow.
    const auto texture = boxGrid("density", boxOf(64, 24, 24), [](const Coord&) { return 1.0f; });
    const TextureVolume volume(*texture, *texture);
    Look look = plainLook(0.3);
    const Camera camera = cameraAlong(volume, {1, 0, 0}, 1e4, 0.01, {9, 9});
    const Image lit = castRays(volume, look, camera, {});
    const VisibleSpace visible(volume, look);
    for (const double strength : {0.4, 1.0}) {
        look.shadows = float(strength);
        const LightGrid grid = lightIn(volume, look, {1, 0, 0});
        const Image image = castRays(volume, look, camera, {}, visible, 0, {.light = &grid});
        EXPECT_NEAR(image.at(4, 4).r, lit.at(4, 4).r * (1 - strength), 1e-3);
        EXPECT_EQ(image.at(4, 4).a, lit.at(4, 4).a);
    }
    look.shadows = 1;
    const LightGrid front = lightIn(volume, look, {-1, 0, 0});
    // ∫ T · T over a thick medium is half of ∫ T.
    EXPECT_NEAR(castRays(volume, look, camera, {.step = 0.1}, visible, 0, {.light = &front}).at(4, 4).r, 0.5, 0.06);
}

} // namespace
} // namespace vdblic
