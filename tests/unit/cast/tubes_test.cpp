#include "vdblic/cast/extinction_grid.h"
#include "vdblic/cast/light_grid.h"
#include "vdblic/cast/ray_cast_params.h"
#include "vdblic/cast/tube_caster.h"
#include "vdblic/cast/tube_tree.h"
#include "vdblic/cast/tubes.h"
#include "vdblic/field/vector.h"
#include "vdblic/look/look.h"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
const auto kUnit = openvdb::math::Transform::createLinearTransform(1.0);

struct Place {
    float x, y, z, radius = 0.5f;
};

void add(Lines& lines, const std::vector<Place>& places)
{
    const auto begin = std::uint32_t(lines.pointCount());
    for (const Place& place : places) {
        lines.positions.emplace_back(place.x, place.y, place.z);
        lines.radii.push_back(place.radius);
        lines.opacities.push_back(1);
        lines.ages.push_back(0);
    }
    lines.lines.push_back({std::int32_t(lines.lines.size()), begin, std::uint32_t(lines.pointCount())});
}

/// Tubes whose driver is 1 everywhere unless it is given.
Tubes tubesOf(const Lines& lines, std::vector<float> drivers = {}, const glm::dvec3& stretch = glm::dvec3(1))
{
    if (drivers.empty()) drivers.assign(lines.pointCount(), 1);
    return {lines, {std::move(drivers), {}}, *kUnit, stretch, [](const openvdb::Coord&) { return true; }};
}

/// White and unlit; a tube whose driver is 1 or more has the opacity, one at 0 or less has none.
Look plain(double opacity)
{
    const TransferFunction white(
        {.colorMap = "gray", .opacity = {{0, 0}, {0.001, opacity}}, .range = std::array{0.0, 1.0}});
    return {white, {.limbDarkening = 0, .foot = 0}, {.model = ShadingModel::kNone}};
}

struct Hit {
    float distance;
    int cone;
    float share, alpha, normal[3];
};

/// All hits of rays from a point in world space; distances in world units.
/// @param towards directions, at most kLanes
std::vector<std::vector<Hit>> hitsOf(const TubeTree& tree, const glm::dvec3& origin,
                                     const std::vector<glm::dvec3>& towards, float least = 0)
{
    const glm::dvec3 at(tree.tubes().worldToTubes() * glm::dvec4(origin, 1));
    TubeTree::Rays rays{.end = broadcast8(std::numeric_limits<float>::infinity()), .least = broadcast8(least)};
    for (std::size_t lane = 0; lane < towards.size(); ++lane) {
        const glm::dvec3 direction = glm::normalize(towards[lane]);
        rays.origin.setLane(int(lane), Float4{float(at.x), float(at.y), float(at.z), 0});
        rays.direction.setLane(int(lane), Float4{float(direction.x), float(direction.y), float(direction.z), 0});
        rays.isActive[lane] = -1;
    }
    std::vector<std::vector<Hit>> hits(towards.size());
    TubeTree::Hits some[TubeTree::kMostHits];
    while (const int count = tree.next(rays, some)) {
        for (int i = 0; i < count; ++i) {
            for (std::size_t lane = 0; lane < towards.size(); ++lane) {
                if (!some[i].isThere[lane]) continue;
                const Vector8& normal = some[i].normal;
                hits[lane].push_back({some[i].distance[lane] / float(tree.tubes().unitsPerWorld()),
                                      some[i].cone[lane],
                                      some[i].share[lane],
                                      some[i].alpha[lane],
                                      {normal.x[lane], normal.y[lane], normal.z[lane]}});
            }
        }
    }
    return hits;
}
std::vector<Hit> hitsOf(const TubeTree& tree, const glm::dvec3& origin, const glm::dvec3& towards, float least = 0)
{
    return hitsOf(tree, origin, std::vector{towards}, least).front();
}

/// The distance from a point to the surface of a line's tube, as of many spheres along it; negative inside.
double distanceTo(const Lines& lines, const Lines::Line& line, const glm::dvec3& point)
{
    constexpr int kSpheres = 100;
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = line.begin; i + 1 < line.end; ++i) {
        for (int step = 0; step <= kSpheres; ++step) {
            const float share = float(step) / kSpheres;
            const openvdb::Vec3f centre = lines.positions[i] + (lines.positions[i + 1] - lines.positions[i]) * share;
            const float radius = lines.radii[i] + (lines.radii[i + 1] - lines.radii[i]) * share;
            least = std::min(least, glm::distance(point, glm::dvec3(centre[0], centre[1], centre[2])) - double(radius));
        }
    }
    return least;
}

TEST(Tubes, ARayMeetsAStraightTubeWhereACylinderIs)
{
    Lines lines;
    add(lines, {{0, 0, 0}, {4, 0, 0}, {10, 0, 0}});
    const Tubes tubes = tubesOf(lines);
    const TubeTree tree(tubes, plain(0.9));
    const auto hits = hitsOf(tree, {7, 0.3, 5}, {0, 0, -1});
    ASSERT_EQ(hits.size(), 1u);
    EXPECT_NEAR(hits[0].distance, 5 - std::sqrt(0.25 - 0.09), 1e-5);
    EXPECT_EQ(hits[0].cone, 1);
    EXPECT_NEAR(hits[0].share, 0.5, 1e-5);
    EXPECT_NEAR(hits[0].normal[1], 0.6, 1e-5);
    EXPECT_NEAR(hits[0].normal[2], 0.8, 1e-5);
    EXPECT_NEAR(hits[0].alpha, 0.9, 1e-5);
    // Round ends; nothing beside them; one entry along the axis.
    EXPECT_EQ(hitsOf(tree, {10.4, 0, 5}, {0, 0, -1}).size(), 1u);
    EXPECT_EQ(hitsOf(tree, {10.6, 0, 5}, {0, 0, -1}).size(), 0u);
    const auto along = hitsOf(tree, {-5, 0, 0}, {1, 0, 0});
    ASSERT_EQ(along.size(), 1u);
    EXPECT_NEAR(along[0].distance, 4.5, 1e-5);
}

TEST(Tubes, RaysEnterBentTubesWhereTheirSpheresBegin)
{
    std::mt19937 random(3);
    std::uniform_real_distribution<float> place(-6, 6), radius(0.2f, 0.9f);
    Lines lines;
    for (int line = 0; line < 9; ++line) {
        std::vector<Place> places(3);
        for (Place& one : places)
            one = {place(random), place(random), place(random), radius(random)};
        add(lines, places);
    }
    const Tubes tubes = tubesOf(lines);
    const TubeTree tree(tubes, plain(0.5));
    int met = 0;
    for (int ray = 0; ray < 150; ++ray) {
        const glm::dvec3 target(place(random), place(random), place(random));
        const glm::dvec3 origin = target + glm::dvec3(place(random), place(random), 30);
        const auto hits = hitsOf(tree, origin, target - origin);
        const glm::dvec3 direction = glm::normalize(target - origin);
        std::size_t entries = 0;
        bool isClear = true; // no line is grazed
        for (const Lines::Line& line : lines.lines) {
            constexpr double kStep = 0.02, kGraze = 0.03;
            double before = 1, nearest = 1;
            for (int step = 0; step < 1750; ++step) {
                const double t = 15 + step * kStep;
                const double distance = distanceTo(lines, line, origin + direction * t);
                if (distance < 0 && before >= 0) ++entries;
                nearest = std::min(nearest, std::abs(distance));
                if ((distance < before) != (distance < 0) && std::abs(distance) < kGraze) isClear = false;
                before = distance;
            }
        }
        for (const Hit& hit : hits) {
            double least = std::numeric_limits<double>::infinity();
            for (const Lines::Line& line : lines.lines)
                least = std::min(least, std::abs(distanceTo(lines, line, origin + direction * double(hit.distance))));
            EXPECT_LT(least, 4e-3);
            ++met;
        }
        EXPECT_TRUE(std::is_sorted(hits.begin(), hits.end(),
                                   [](const auto& a, const auto& b) { return a.distance < b.distance; }));
        if (isClear) {
            EXPECT_EQ(hits.size(), entries) << "ray " << ray;
        }
    }
    EXPECT_GT(met, 80);
}

TEST(Tubes, ARayMeetsMoreTubesThanItHoldsAtATime)
{
    Lines lines;
    for (int i = 0; i < 21; ++i)
        add(lines, {{-3, 0, 2.0f * float(i)}, {3, 0, 2.0f * float(i)}});
    static_assert(21 > TubeTree::kMostHits);
    const Tubes tubes = tubesOf(lines);
    const auto hits = hitsOf(TubeTree(tubes, plain(0.01)), {0, 0, 100}, {0, 0, -1});
    ASSERT_EQ(hits.size(), 21u);
    for (std::size_t i = 0; i < hits.size(); ++i)
        EXPECT_NEAR(hits[i].distance, 59.5 + 2.0 * double(i), 1e-3);
    // Of opaque ones it meets only as many as leave light.
    EXPECT_EQ(hitsOf(TubeTree(tubes, plain(0.9)), {0, 0, 100}, {0, 0, -1}, 1 / 256.0f).size(), 3u);
}

TEST(Tubes, ARayMeetsTheSameTubesAloneAndBesideOthers)
{
    std::mt19937 random(5);
    std::uniform_real_distribution<float> place(-6, 6), radius(0.2f, 0.9f);
    Lines lines;
    for (int line = 0; line < 200; ++line)
        add(lines, {{place(random), place(random), place(random), radius(random)},
                    {place(random), place(random), place(random), radius(random)},
                    {place(random), place(random), place(random), radius(random)}});
    const Tubes tubes = tubesOf(lines);
    std::size_t most = 0, least = 1000;
    for (const auto& [opacity, end] : {std::pair{0.1, 0.0f}, {0.3, 0.2f}}) {
        const TubeTree tree(tubes, plain(opacity));
        std::vector<glm::dvec3> towards(kLanes);
        for (glm::dvec3& direction : towards)
            direction = {place(random), place(random), -30};
        const auto together = hitsOf(tree, {0, 0, 30}, towards, end);
        for (std::size_t i = 0; i < towards.size(); ++i) {
            const std::vector<Hit> alone = hitsOf(tree, {0, 0, 30}, towards[i], end);
            ASSERT_EQ(together[i].size(), alone.size());
            most = std::max(most, alone.size());
            least = std::min(least, alone.size());
            for (std::size_t hit = 0; hit < alone.size(); ++hit) {
                EXPECT_EQ(together[i][hit].distance, alone[hit].distance);
                EXPECT_EQ(together[i][hit].cone, alone[hit].cone);
            }
        }
    }
    EXPECT_GT(most, std::size_t(TubeTree::kMostHits)); // both through several searches and through one
    EXPECT_LT(least, std::size_t(TubeTree::kMostHits));
}

TEST(Tubes, WhatCannotBeSeenIsLeftOut)
{
    Lines lines;
    add(lines, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}); // a NaN at its end, two in its middle
    add(lines, {{0, 5, 0, 0}, {9, 5, 0, 0}});                 // without width
    add(lines, {{5, 9, 0}});                                  // of one point
    add(lines, {{5, 12, 0}, {5, 12, 0}, {5, 12, 0}});         // at rest
    add(lines, {{0, 15, 0}, {9, 15, 0}});                     // hidden by its driver
    const Tubes tubes = tubesOf(lines, {1, kNone, kNone, 1, 1, 1, 1, 1, 1, 1, 0, 0});
    EXPECT_EQ(tubes.unusable(), 1u);
    const TubeTree tree(tubes, plain(0.9));
    const auto count = [&](double x, double y) { return hitsOf(tree, {x, y, 9}, {0, 0, -1}).size(); };
    EXPECT_EQ(count(0.5, 0), 1u);
    EXPECT_EQ(count(1.5, 0), 0u);
    EXPECT_EQ(count(4, 5), 0u);
    EXPECT_EQ(count(5, 9), 0u);
    EXPECT_EQ(count(5.3, 12), 1u);
    EXPECT_EQ(count(4, 15), 0u);
    EXPECT_TRUE(tubesOf(Lines{}).empty());
    EXPECT_TRUE(tubesOf(Lines{}).samples().texture.empty());
    const Tubes none = tubesOf(Lines{});
    EXPECT_TRUE(TubeTree(none, plain(1)).cones().empty());
}

TEST(Tubes, TubesAtRestAreSampledToo)
{
    Lines lines;
    add(lines, {{0, 0, 0}, {0, 0, 0}});
    add(lines, {{5, 0, 0}, {5, 0, 0}});
    const Tubes tubes = tubesOf(lines, {1, 1, 2, 2});
    const VolumeSamples samples = tubes.samples();
    const auto ones = std::count(samples.driver.begin(), samples.driver.end(), 1.0f);
    EXPECT_NEAR(double(ones) / double(samples.driver.size()), 0.5, 1e-4);
    EXPECT_GT(tubes.crossings(), 0);
}

TEST(Tubes, ASampleStandsForEqualLengths)
{
    Lines lines;
    add(lines, {{0, 0, 0}, {30, 0, 0}});
    add(lines, {{0, 9, 0}, {10, 9, 0}});
    const VolumeSamples samples = tubesOf(lines, {3, 3, 1, 1}).samples();
    const auto threes = std::count(samples.driver.begin(), samples.driver.end(), 3.0f);
    EXPECT_NEAR(double(threes) / double(samples.driver.size()), 31.0 / 42, 1e-4); // with the ends, 0.5 thick
}

/// A grating of parallel tubes, half as wide as they are apart, across the light's way.
Lines grating()
{
    Lines lines;
    for (int i = 0; i < 160; ++i)
        add(lines, {{0, 0.25f * float(i), 0, 0.0625f}, {40, 0.25f * float(i), 0, 0.0625f}});
    add(lines, {{0, 0, -40, 0.001f}, {40, 39, -40, 0.001f}}); // makes the box high
    return lines;
}

TEST(Tubes, HalfOfTheLightPassesAGrating)
{
    const Tubes tubes = tubesOf(grating());
    const Look look = plain(0.95);
    const TubeTree tree(tubes, look);
    const ExtinctionGrid extinctions(tree);
    Look shadows = look;
    shadows.shadows = 1;
    const LightGrid light(extinctions, AmbientLight(extinctions, tubes, shadows), tubes, shadows, {0, 0, 1});
    const auto at = [&](double z) { return light.at(glm::dvec3(tubes.worldToIndex() * glm::dvec4(20, 20, z, 1))); };
    EXPECT_NEAR(at(-30), std::exp(-0.95 * 0.5 * (3.14159 / 4)), 0.02); // the mean over all directions
}

TEST(Tubes, APictureShowsColourAlphaDepthAndNormal)
{
    Lines lines;
    add(lines, {{-20, 0, 0, 2}, {20, 0, 0, 2}});
    add(lines, {{-20, 0, -10, 2}, {20, 0, -10, 2}});
    const Tubes tubes = tubesOf(lines);
    const TubeTree tree(tubes, plain(0.5));
    const Camera camera({.projection = Projection::kOrthographic,
                         .eye = glm::dvec3(0, 0, 100),
                         .target = glm::dvec3(0),
                         .viewHeight = 10.0},
                        tubes.corners(), {21, 21});
    RayCastParams params;
    params.layers = true;
    const Image image = castTubes(tree, plain(0.5), camera, params);
    const std::size_t middle = 10 * 21 + 10;
    EXPECT_NEAR(image.pixels[middle].a, 0.75f, 1e-4);
    EXPECT_NEAR(image.pixels[middle].r, 0.75f, 1e-4); // white
    EXPECT_NEAR(image.layers[middle].depth, (98 * 0.5 + 108 * 0.25) / 0.75, 1e-3);
    EXPECT_NEAR(image.layers[middle].normal.z, 1, 1e-4);
    EXPECT_EQ(image.layers[middle].samples, 2);
    EXPECT_EQ(image.pixels[0].a, 0);
    params.clip.planes = {{{0, 0, -5}, {0, 0, -1}}};
    EXPECT_NEAR(castTubes(tree, plain(0.5), camera, params).pixels[middle].a, 0.5f, 1e-4);
    params.clip.planes = {{{0, 0, 5}, {0, 0, 1}}};
    EXPECT_EQ(castTubes(tree, plain(0.5), camera, params).pixels[middle].a, 0);
}

TEST(Tubes, TheOutlineOfATubeShowsWhatIsBehindAllTubes)
{
    Lines lines;
    add(lines, {{-20, 0, 0, 2}, {20, 0, 0, 2}});
    add(lines, {{-20, 0, -50, 30}, {20, 0, -50, 30}}); // behind, and seen from its front
    const Tubes tubes = tubesOf(lines);
    Look look = plain(0.5);
    look.halo.strength = 4;
    look.background.color = {0, 0, 1};
    const Camera camera({.projection = Projection::kOrthographic,
                         .eye = glm::dvec3(0, 0, 100),
                         .target = glm::dvec3(0),
                         .viewHeight = 10.5}, // two pixels a unit
                        tubes.corners(), {21, 21});
    const Image image = castTubes(TubeTree(tubes, look), look, camera, {});
    for (const int aside : {0, 1, 2, 3}) {
        const double halo = 4 * std::pow(0.5 * aside / 2, 4), behind = 4 * std::pow(0.5 * aside / 30, 4);
        const double alpha = 1 - std::pow(0.5, 1 + halo), left = 1 - alpha;
        const double alphaBehind = 1 - std::pow(0.5, 1 + behind);
        const glm::vec4& pixel = image.pixels[std::size_t(10 + aside) * 21 + 10];
        EXPECT_NEAR(pixel.a, alpha + left * alphaBehind, 1e-4);
        EXPECT_NEAR(pixel.b, pixel.a, 1e-4); // of white tubes and of the background
        EXPECT_NEAR(pixel.r, alpha / (1 + halo) + left * alphaBehind / (1 + behind), 1e-4);
    }
}

TEST(Tubes, AStretchedPictureHasTubesAsRoundAsBefore)
{
    Lines lines;
    add(lines, {{0, 0, 0}, {0, 0, 10}});
    const Tubes tubes = tubesOf(lines, {}, {1, 1, 8});
    const auto hits = hitsOf(TubeTree(tubes, plain(0.9)), {9, 0, 40}, {-1, 0, 0});
    ASSERT_EQ(hits.size(), 1u);
    EXPECT_NEAR(hits[0].distance, 9 - 0.5 * 2, 1e-5); // 2 = ∛8
    EXPECT_NEAR(hits[0].share, 0.5, 1e-5);
}

} // namespace
} // namespace vdblic
