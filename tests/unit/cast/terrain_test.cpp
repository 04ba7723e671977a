#include "vdblic/cast/terrain.h"

#include "cast/test_scene.h"
#include "vdblic/cast/solid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace vdblic {
namespace {

using openvdb::Coord;

/// A domain of 64 x 48 x 30 voxels over columns of ground; heights are those of blocks of 4 x 4 voxels.
openvdb::FloatGrid::Ptr above(const std::function<int(int, int)>& height)
{
    auto texture = boxGrid("density", boxOf(64, 48, 30), [](const Coord&) { return 1.0f; });
    for (int x = 0; x < 64; ++x) {
        for (int y = 0; y < 48; ++y) {
            for (int z = 0; z < height(x / 4, y / 4); ++z)
                texture->tree().setValueOff({x, y, z});
        }
    }
    return texture;
}

/// The height of a solid's surface over a column, from the faces of the lowest voxels; far below 0 if there is none.
double heightOver(const Solid& solid, int x, int y)
{
    for (int z = 29; z > -4; --z) {
        const double low = solid.levelSet->tree().getValue({x, y, z}),
                     high = solid.levelSet->tree().getValue({x, y, z + 1});
        if (low < 0 && high >= 0) return z + 0.5 + low / (low - high);
    }
    return -100;
}

TEST(Ground, IsSmoothAndInOnePiece)
{
    // A hill in stairs of two voxels, and a block for itself.
    const auto hill = [](double x, double y) {
        return 20 * std::exp(-((x - 40) * (x - 40) + (y - 24) * (y - 24)) / 260);
    };
    const auto height = [&](int i, int j) {
        return i == 2 && j == 9 ? 2 : 2 * int(std::lround(hill(4 * i + 1.5, 4 * j + 1.5) / 2));
    };
    const auto texture = above(height);
    const Solid solid = makeSolid("domain", *texture, glm::dvec3(1), 1);
    double farthest = 0, steepest = 0, sharpest = 0;
    for (int x = 1; x < 63; ++x) {
        for (int y = 1; y < 47; ++y) {
            const double here = heightOver(solid, x, y), next = heightOver(solid, x + 1, y);
            const double before = heightOver(solid, x - 1, y);
            if (std::abs(x / 4 - 2) > 2 || std::abs(y / 4 - 9) > 2)
                farthest = std::max(farthest, std::abs(here - hill(x, y)));
            steepest = std::max(steepest, std::abs(next - here));
            sharpest = std::max(sharpest, std::abs(next - 2 * here + before));
            EXPECT_LT(solid.levelSet->tree().getValue({x, y, -1}), 0) << x << " " << y; // the plate
        }
    }
    EXPECT_LT(farthest, 2);   // a step of the data
    EXPECT_LT(steepest, 1.6); // the hill itself is 1.1 steep; stairs are 2
    EXPECT_LT(sharpest, 0.5);
    EXPECT_LT(heightOver(solid, 10, 38), 1.5);
    EXPECT_GT(heightOver(solid, 10, 38), 0.3);
    // It ends at the sides of the box.
    EXPECT_GT(solid.levelSet->tree().getValue({-1, 20, -1}), 0);
    EXPECT_GT(solid.levelSet->tree().getValue({64, 20, -1}), 0);
}

TEST(Ground, IsNoBodyWithWalls)
{
    const Solid solid = makeSolid(
        "domain", *above([](int i, int j) { return i >= 5 && i < 8 && j >= 4 && j < 7 ? 24 : 0; }), glm::dvec3(1), 1);
    const auto surface = [&](const Coord& inside, const Coord& outside) {
        const double in = solid.levelSet->tree().getValue(inside), out = solid.levelSet->tree().getValue(outside);
        EXPECT_LT(in, 0) << inside;
        EXPECT_GT(out, 0) << outside;
        return in / (in - out);
    };
    for (const int z : {4, 12, 20}) {
        EXPECT_NEAR(surface({20, 22, z}, {19, 22, z}), 0.5, 0.1);
        EXPECT_NEAR(surface({31, 22, z}, {32, 22, z}), 0.5, 0.1);
    }
    EXPECT_NEAR(surface({26, 22, 23}, {26, 22, 24}), 0.5, 0.1);
    EXPECT_GT(solid.levelSet->tree().getValue({50, 10, -1}), 0); // no plate
}

} // namespace
} // namespace vdblic
