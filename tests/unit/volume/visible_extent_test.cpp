#include "vdblic/volume/visible_extent.h"

#include "cast/test_scene.h"
#include "vdblic/core/exchange.h"

#include <gtest/gtest.h>

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
    // Leaves that hold the opaque voxels, or interpolate towards them.
    EXPECT_LT(glm::distance(low, {7.5, -0.5, 15.5}), 1e-9);
    EXPECT_LT(glm::distance(high, {47.5, 63.5, 63.5}), 1e-9);
    const auto cut = visibleExtent(volume, halfLook(), {.planes = {{{0, 32, 0}, {0, 1, 0}}}}, alone);
    EXPECT_TRUE(std::all_of(cut.begin(), cut.end(), [](const glm::dvec3& point) { return point.y >= 31; }));
    EXPECT_TRUE(visibleExtent(volume, halfLook(), {.planes = {{{99, 0, 0}, {1, 0, 0}}}}, alone).empty());
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
        EXPECT_GT(std::max(high.x - low.x, high.y - low.y), 0.94);
        EXPECT_GT(std::min(low.x, low.y), 0);
        EXPECT_LT(std::max(high.x, high.y), 1);
    }
}

} // namespace
} // namespace vdblic
