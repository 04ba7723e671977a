#include "vdblic/coherence/cleanness.h"

#include "methods/test_flow.h"
#include "vdblic/coherence/smoothed_texture.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/noise/noise.h"

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <utility>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::Vec3d;
using openvdb::Vec3f;

const CoherenceParams kPoints{.samples = 20'000};
const CoordBBox kCleanBox({-3, 5, 2}, {60, 44, 41});

using ValueAt = std::function<std::optional<float>(const Coord&)>;

SmoothedTexture cleanTexture(const ValueAt& valueAt, const CoordBBox& box = kCleanBox)
{
    openvdb::FloatTree tree(0);
    for (auto voxel = box.begin(); voxel; ++voxel) {
        if (const auto value = valueAt(*voxel)) tree.setValue(*voxel, *value);
    }
    return SmoothedTexture(tree);
}

/// @param velocity the same everywhere [voxels of the velocity per step]
CleannessByClass measureUniform(const SmoothedTexture& texture, const SmoothedTexture* next, const Vec3f& velocity,
                                const CoordBBox& box = kCleanBox, const Refinement& refinement = {})
{
    const auto frames =
        test::refined(test::makeFrames(box, 2, [&](const Coord&, int) { return velocity; }), refinement);
    VelocityField field;
    field.build(frames[0].domain, {frames[0].values->tree(), openvdb::Mat3d::identity()},
                {frames[1].values->tree(), openvdb::Mat3d::identity()});
    return measureCleanness(texture, next, field, kPoints, 1);
}

float grain(const Coord& at)
{
    return float(noiseValue(at[0], at[1], at[2], 1)) / float(kNoiseMax);
}

/// Waves across a direction, so that values are constant along it. They are long, so central differences are accurate.
float linesAlong(const Vec3d& direction, const Coord& at)
{
    Vec3d first = direction.cross(Vec3d(0.3, 0.1, 1)), second = direction.cross(first);
    first.normalize();
    second.normalize();
    return float(0.5 + 0.2 * std::sin(0.5 * first.dot(at.asVec3d())) + 0.2 * std::sin(0.4 * second.dot(at.asVec3d())));
}

/// Coordinates modulo 10.
Coord inTen(const Coord& at)
{
    const auto modulo = [](int n) { return (n % 10 + 10) % 10; };
    return {modulo(at[0]), modulo(at[1]), modulo(at[2])};
}

TEST(Cleanness, OfLinesIsTheirAngleToTheFlow)
{
    const Vec3d along(0.8, 0.36, 0.48);
    const auto texture = cleanTexture([&](const Coord& at) { return linesAlong(along, at); });
    for (const double degrees : {0.0, 20.0, 70.0}) {
        Vec3d aside = along.cross(Vec3d(0, 1, 0));
        aside.normalize();
        const double angle = degrees * M_PI / 180;
        const Vec3d flow = 3 * (std::cos(angle) * along + std::sin(angle) * aside);
        const Cleanness found = measureUniform(texture, nullptr, Vec3f(flow))[1];
        EXPECT_GT(found.points, 10'000u);
        EXPECT_NEAR(found.angle, degrees, 1.5);
        EXPECT_GT(found.line, 0.95);
        EXPECT_EQ(found.isolated, 0);
        EXPECT_NEAR(found.deviation, 0.2, 0.01); // of two sines of 0.2
        EXPECT_TRUE(std::isnan(found.temporal));
    }
}

// Half of the directions of space are more than 60 degrees from a line.
TEST(Cleanness, OfGrainsIsNoLineAndAnyAngle)
{
    const auto texture = cleanTexture(grain);
    const Cleanness found = measureUniform(texture, nullptr, Vec3f(3, 1, 0))[1];
    EXPECT_LT(found.line, 0.25);
    EXPECT_NEAR(found.angle, 60, 4); // central differences favour the axes a little
    EXPECT_NEAR(found.deviation, std::sqrt(1 / 12.0), 0.003);
    // The extremes of 27 values lie this far from the next ones: (1 − 0.05)²⁷ of the ranges, for each end, of 27.
    EXPECT_NEAR(found.isolated, 2.0 / 27 * std::pow(0.95, 27), 0.001);
}

TEST(Cleanness, OfAConstantOrOfLayersHasNoAngle)
{
    const auto grey = cleanTexture([](const Coord&) { return 0.25f; });
    const auto layers = cleanTexture([](const Coord& at) { return float(0.5 + 0.4 * std::sin(0.7 * at[2])); });
    for (const SmoothedTexture* texture : {&grey, &layers}) {
        const Cleanness found = measureUniform(*texture, texture, Vec3f(3, 0, 0))[1];
        EXPECT_EQ(found.line, 0);
        EXPECT_TRUE(std::isnan(found.angle));
    }
    EXPECT_EQ(measureUniform(grey, &grey, Vec3f(3, 0, 0))[1].deviation, 0);
    EXPECT_TRUE(std::isnan(measureUniform(grey, &grey, Vec3f(3, 0, 0))[1].temporal));
}

TEST(Cleanness, CountsIsolatedVoxels)
{
    const auto planted = [](const Coord& at) {
        const Coord place = inTen(at);
        if (place == Coord(0, 0, 0)) return 0.56f;
        if (place == Coord(5, 5, 5)) return 0.44f;
        if (place == Coord(5, 0, 0)) return 0.54f;                           // too little
        if (place == Coord(0, 5, 0) || place == Coord(1, 6, 1)) return 0.9f; // two neighbours
        return 0.5f;
    };
    const Cleanness found = measureUniform(cleanTexture(planted), nullptr, Vec3f(3, 0, 0))[1];
    EXPECT_NEAR(found.isolated, 2e-3, 5e-5);
}

TEST(Cleanness, OfATextureThatMovesWithTheFlowIsOne)
{
    const auto before = cleanTexture(grain);
    const auto after = cleanTexture([](const Coord& at) { return grain(at - Coord(4, -3, 0)); });
    const CleannessByClass moved = measureUniform(before, &after, Vec3f(4, -3, 0));
    EXPECT_NEAR(moved[2].temporal, 1, 1e-5);
    EXPECT_NEAR(moved[2].samePlace, 0, 0.03);
    const CleannessByClass still = measureUniform(before, &before, Vec3f(4, -3, 0));
    EXPECT_NEAR(still[2].temporal, 0, 0.03);
    EXPECT_NEAR(still[2].samePlace, 1, 1e-9);
    for (const std::size_t other : {0, 1, 3}) {
        EXPECT_EQ(moved[other].points, 0u);
        for (const CleannessFigure& figure : kCleannessFigures)
            EXPECT_TRUE(std::isnan(moved[other].*figure.value)) << figure.name;
    }
}

TEST(Cleanness, ClassesDisplacements)
{
    const auto texture = cleanTexture(grain);
    const std::array<std::pair<float, int>, 8> expected = {
        {{0.5f, -1}, {0.6f, 0}, {2, 0}, {2.1f, 1}, {8, 2}, {8.1f, 3}, {30, 3}, {30.1f, -1}}};
    for (const auto& [displacement, displacementClass] : expected) {
        const CleannessByClass found = measureUniform(texture, nullptr, Vec3f(0, displacement, 0));
        for (int i = 0; i < int(found.size()); ++i)
            EXPECT_EQ(found[std::size_t(i)].points > 0, i == displacementClass) << displacement << ' ' << i;
    }
}

TEST(Cleanness, OfARefinedTextureIsInItsVoxels)
{
    const Refinement refinement{{4, 1, 2}};
    const CoordBBox coarse({-2, 1, 0}, {17, 40, 19}), fine({-8, 1, 0}, {71, 40, 39});
    const auto texture = cleanTexture([](const Coord& at) { return linesAlong(Vec3d(0, 0, 1), at); }, fine);
    EXPECT_GT(measureUniform(texture, nullptr, Vec3f(0, 1.5f, 0), coarse, refinement)[0].points, 0u);
    EXPECT_GT(measureUniform(texture, nullptr, Vec3f(1.5f, 0, 0), coarse, refinement)[2].points, 0u);
    // (0, 2, 1) is (0, 2, 2) in the texture's voxels.
    EXPECT_NEAR(measureUniform(texture, nullptr, Vec3f(0, 2, 1), coarse, refinement)[1].angle, 45, 1.5);
}

// The outermost voxels, and those around a hole, are the neighbours of others at most.
TEST(Cleanness, LeavesRimsAndHolesOut)
{
    const auto grey = [](const Coord& at) -> std::optional<float> {
        CoordBBox inner = kCleanBox, hole({20, 20, 18}, {26, 27, 24}), around = hole;
        inner.expand(-1);
        around.expand(1);
        if (hole.isInside(at)) return std::nullopt;
        if (!inner.isInside(at) || around.isInside(at)) return float((at[0] + at[1] + at[2]) & 1);
        return 0.5f;
    };
    const Cleanness found = measureUniform(cleanTexture(grey), nullptr, Vec3f(3, 0, 0))[1];
    EXPECT_GT(found.points, 5000u);
    EXPECT_EQ(found.deviation, 0);
    EXPECT_EQ(found.isolated, 0);
}

TEST(Cleanness, OfFewPointsIsUnknown)
{
    const CoordBBox small({0, 0, 0}, {39, 39, 7});
    const auto texture = cleanTexture(grain, small);
    const auto fast = [](const Coord& at, int) { return Vec3f(at[0] < 5 ? 3.0f : 1.0f, 0, 0); };
    const auto frames = test::makeFrames(small, 2, fast);
    VelocityField field;
    field.build(frames[0].domain, {frames[0].values->tree(), openvdb::Mat3d::identity()},
                {frames[1].values->tree(), openvdb::Mat3d::identity()});
    const CleannessByClass found = measureCleanness(texture, &texture, field, {.samples = 9000}, 1);
    EXPECT_GT(found[0].points, kLeastClassPoints);
    EXPECT_FALSE(std::isnan(found[0].line));
    EXPECT_GT(found[1].points, 0u);
    EXPECT_LT(found[1].points, kLeastClassPoints);
    for (const CleannessFigure& figure : kCleannessFigures)
        EXPECT_TRUE(std::isnan(found[1].*figure.value)) << figure.name;
}

} // namespace
} // namespace vdblic
