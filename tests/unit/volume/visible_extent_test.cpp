#include "vdblic/volume/visible_extent.h"

#include "cast/test_scene.h"
#include "vdblic/core/exchange.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace vdblic {
namespace {

OneProcess alone;

using openvdb::Coord;

/// Opaque only where the driver is above a half.
Look halfLook()
{
    const TransferFunction transfer({.opacity = {{0, 0}, {0.5, 0}, {0.51, 0.9}}, .range = std::array{0.0, 1.0}});
    return {transfer, {0, 1, 0, 0}, {}};
}

TEST(VisibleExtent, IsThatOfWhatIsOpaque)
{
    const auto texture = boxGrid("density", boxOf(64, 64, 64), [](const Coord&) { return 1.0f; });
    const auto driver = boxGrid("magnitude", boxOf(64, 64, 64),
                                [](const Coord& c) { return c.x() >= 16 && c.x() < 40 && c.z() >= 24 ? 1.0f : 0.0f; });
    const TextureVolume volume(*texture, *driver);
    glm::dvec3 low(1e9), high(-1e9);
    for (const glm::dvec3& point : visibleExtent(volume, halfLook(), {}, alone)) {
        low = glm::min(low, point);
        high = glm::max(high, point);
    }
    EXPECT_LT(glm::distance(low, {15.5, -0.5, 23.5}), 1e-9);
    EXPECT_LT(glm::distance(high, {39.5, 63.5, 63.5}), 1e-9);
    const auto cut = visibleExtent(volume, halfLook(), {.planes = {{{0, 32, 0}, {0, 1, 0}}}}, alone);
    EXPECT_TRUE(std::all_of(cut.begin(), cut.end(), [](const glm::dvec3& point) { return point.y >= 31; }));
    EXPECT_TRUE(visibleExtent(volume, halfLook(), {.planes = {{{99, 0, 0}, {1, 0, 0}}}}, alone).empty());
}

TEST(VisibleExtent, HazeAroundABallDoesNotCount)
{
    const auto radius = [](const Coord& c) { return glm::distance(glm::dvec3(c.x(), c.y(), c.z()), {60, 40, 50}); };
    const auto texture = boxGrid("density", boxOf(96, 96, 96), [](const Coord&) { return 1.0f; });
    const auto driver =
        boxGrid("magnitude", boxOf(96, 96, 96), [&](const Coord& c) { return radius(c) < 20 ? 1.0f : 0.4f; });
    const TransferFunction transfer({.opacity = {{0, 0}, {0.5, 2e-5}, {1, 0.3}}, .range = std::array{0.0, 1.0}});
    const TextureVolume volume(*texture, *driver);
    const auto points = visibleExtent(volume, {transfer, {0, 1, 0, 0}, {}}, {}, alone);
    double farthest = 0;
    for (const glm::dvec3& point : points)
        farthest = std::max(farthest, glm::distance(point, {60, 40, 50}));
    EXPECT_GT(farthest, 19.5);
    EXPECT_LT(farthest, 24); // corners of cells
    // Where haze is all that there is, it is seen.
    const TransferFunction faint({.opacity = {{0, 0}, {0.5, 2e-5}, {1, 2e-5}}, .range = std::array{0.0, 1.0}});
    glm::dvec3 low(1e9);
    for (const glm::dvec3& point : visibleExtent(volume, {faint, {0, 1, 0, 0}, {}}, {}, alone))
        low = glm::min(low, point);
    EXPECT_LT(glm::distance(low, {-0.5, -0.5, -0.5}), 1e-9);
}

TEST(VisibleExtent, FillsThePicture)
{
    // A flat and long domain of which a part is visible.
    const auto texture = boxGrid("density", boxOf(160, 96, 16), [](const Coord&) { return 1.0f; });
    const auto driver =
        boxGrid("magnitude", boxOf(160, 96, 16), [](const Coord& c) { return c.x() < 64 && c.y() > 40 ? 1.0f : 0.0f; });
    const TextureVolume volume(*texture, *driver);
    const auto points = visibleExtent(volume, halfLook(), {}, alone);
    for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
        const Camera camera({.projection = projection}, volume.corners(), {320, 200}, points);
        glm::dvec2 low(1), high(0);
        for (const glm::dvec3& point : points) {
            const glm::dvec4 ndc = camera.worldToNdc() * glm::dvec4(point, 1);
            low = glm::min(low, glm::dvec2(ndc) / ndc.w);
            high = glm::max(high, glm::dvec2(ndc) / ndc.w);
        }
        EXPECT_GT(std::max(high.x - low.x, high.y - low.y), 0.91);
        EXPECT_LT(std::max(high.x - low.x, high.y - low.y), 0.95);
        EXPECT_GT(std::min(low.x, low.y), 0);
        EXPECT_LT(std::max(high.x, high.y), 1);
    }
}

} // namespace
} // namespace vdblic
