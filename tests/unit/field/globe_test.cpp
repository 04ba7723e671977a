#include "vdblic/core/errors.h"
#include "vdblic/field/globe.h"

#include <gtest/gtest.h>
#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3d;
using std::numbers::pi;

constexpr double kWind = 7.848e-6, kEarthRate = 7.292e-5; // radians per second

/// Degrees, and radii of the Earth.
Vec3d placeOf(double longitude, double latitude, double radius = 1)
{
    const double east = longitude * pi / 180, north = latitude * pi / 180;
    return radius * kEarthRadius *
           Vec3d(std::cos(north) * std::cos(east), std::cos(north) * std::sin(east), std::sin(north));
}

Vec3d turned(const Vec3d& p, double angle)
{
    return {std::cos(angle) * p.x() - std::sin(angle) * p.y(), std::sin(angle) * p.x() + std::cos(angle) * p.y(),
            p.z()};
}

/// Places all over the Earth, poles included.
std::vector<Vec3d> placesOnEarth()
{
    std::vector<Vec3d> places{placeOf(0, 90), placeOf(0, -90)};
    for (int longitude = -180; longitude < 180; longitude += 17) {
        for (int latitude = -89; latitude < 90; latitude += 13)
            places.push_back(placeOf(longitude, latitude, 1 + 0.001 * latitude));
    }
    return places;
}

/// The change of a function of place along each axis.
template<typename Function>
Vec3d slopeOf(const Function& function, const Vec3d& place)
{
    constexpr double kStep = 1e-3;
    Vec3d slope;
    for (int axis = 0; axis < 3; ++axis) {
        Vec3d step(0);
        step[axis] = kStep;
        slope[axis] = (function(place + step) - function(place - step)) / (2 * kStep);
    }
    return slope;
}

Vec3d curlOf(const Vec3d& place, double time)
{
    Vec3d slopes[3];
    for (int axis = 0; axis < 3; ++axis)
        slopes[axis] = slopeOf([&](const Vec3d& p) { return rossbyWave(p, time)[axis]; }, place);
    return {slopes[2].y() - slopes[1].z(), slopes[0].z() - slopes[2].x(), slopes[1].x() - slopes[0].y()};
}

TEST(RossbyWave, HasTheVelocitiesOfItsFormulaAtKnownPlaces)
{
    const auto expectWind = [](double longitude, double latitude, double eastward, double northward) {
        const Vec3d place = placeOf(longitude, latitude), velocity = rossbyWave(place, 0) / (kEarthRadius * kWind);
        const Vec3d east = Vec3d(-place.y(), place.x(), 0).unit(), north = place.cross(east).unit();
        EXPECT_NEAR(velocity.dot(east), eastward, 1e-12) << longitude << " " << latitude;
        EXPECT_NEAR(velocity.dot(north), northward, 1e-12) << longitude << " " << latitude;
    };
    expectWind(0, 0, 0, 0); // 1 − cos 4λ
    expectWind(45, 0, 2, 0);
    expectWind(-67.5, 0, 1, 0);
    const double cosine = std::sqrt(0.75);
    expectWind(0, 30, cosine + std::pow(cosine, 3) * 0.25, 0); // cos φ + cos³φ (4 sin²φ − cos²φ)
    expectWind(22.5, 30, cosine, -2 * std::pow(cosine, 3));    // −4 cos³φ sin φ
    expectWind(22.5, -30, cosine, 2 * std::pow(cosine, 3));
    EXPECT_LT(rossbyWave(placeOf(0, 90), 1e5).length(), 1e-15 * kWind);
    EXPECT_EQ(rossbyWave(Vec3d(0, 0, -3), 1e5), Vec3d(0));
    EXPECT_EQ(rossbyWave(Vec3d(0), 1), Vec3d(0));
}

TEST(RossbyWave, IsHorizontalWithoutDivergenceAndRigidAlongARadius)
{
    for (const Vec3d& place : placesOnEarth()) {
        for (const double time : {0.0, 123456.0}) {
            const Vec3d velocity = rossbyWave(place, time);
            EXPECT_LT(std::abs(velocity.dot(place.unit())), 1e-14 * kWind) << place;
            double divergence = 0;
            for (int axis = 0; axis < 3; ++axis)
                divergence += slopeOf([&](const Vec3d& p) { return rossbyWave(p, time)[axis]; }, place)[axis];
            EXPECT_LT(std::abs(divergence), 1e-6 * kWind) << place;
            EXPECT_LT((rossbyWave(1.1 * place, time) - 1.1 * velocity).length(), 1e-13 * kWind) << place;
        }
    }
}

TEST(RossbyWave, TurnsUnchanged)
{
    for (const Vec3d& place : placesOnEarth()) {
        for (const double time : {-7e4, 3e5, 5e6}) {
            const double angle = 2.46346666667e-6 * time; // (28 ω − 2 Ω)/30
            const Vec3d later = rossbyWave(turned(place, angle), time);
            EXPECT_LT((later - turned(rossbyWave(place, 0), angle)).length(), 1e-8 * kWind) << place << " " << time;
        }
    }
}

/// Fluid keeps the vorticity that an observer at rest in space sees: ∂ζ/∂t + v·∇(ζ + 2Ω sin φ) = 0.
TEST(RossbyWave, SolvesTheBarotropicVorticityEquation)
{
    double largest = 0, terms = 0;
    for (const Vec3d& place : placesOnEarth()) {
        constexpr double kTime = 2e5, kStep = 100;
        const auto relative = [](const Vec3d& p, double time) { return curlOf(p, time).dot(p.unit()); };
        const auto absolute = [&](const Vec3d& p) { return relative(p, kTime) + 2 * kEarthRate * p.z() / p.length(); };
        const double local = (relative(place, kTime + kStep) - relative(place, kTime - kStep)) / (2 * kStep);
        const double carried = rossbyWave(place, kTime).dot(slopeOf(absolute, place));
        largest = std::max(largest, std::abs(local + carried));
        terms = std::max(terms, std::abs(local));
    }
    EXPECT_GT(terms, 1e-10);
    EXPECT_LT(largest, 1e-4 * terms);
}

TEST(Globe, IsAShellOfItsVoxelsWithAMargin)
{
    constexpr double kVoxel = 0.25, kTop = kEarthRadius + 5 * kVoxel;
    const Globe globe = makeGlobe(kVoxel);
    std::uint64_t voxels = 0;
    const openvdb::MaskTree& topology = globe.domain->topology();
    for (int x = -40; x <= 40; ++x) {
        for (int y = -40; y <= 40; ++y) {
            for (int z = -40; z <= 40; ++z) {
                const double radius = kVoxel * Vec3d(x, y, z).length();
                const bool within = radius >= kEarthRadius - 2 * kVoxel && radius <= kTop + 2 * kVoxel;
                ASSERT_EQ(topology.isValueOn(Coord(x, y, z)), within) << x << " " << y << " " << z;
                if (!within) continue;
                ++voxels;
                const double rim = globe.rim->tree().getValue(Coord(x, y, z));
                ASSERT_NEAR(rim, std::min(radius - kEarthRadius, kTop - radius), 1e-6);
            }
        }
    }
    EXPECT_EQ(globe.domain->voxelCount(), voxels);
    EXPECT_NEAR(voxelsOfGlobe(kVoxel) / double(voxels), 1, 0.01);
    EXPECT_TRUE(globe.rim->tree().hasSameTopology(topology));
}

TEST(Globe, HasTheEarthBelow)
{
    const Globe globe = makeGlobe(0.2);
    EXPECT_EQ(globe.solid->getGridClass(), openvdb::GRID_LEVEL_SET);
    for (const Vec3d& place : placesOnEarth()) {
        const Vec3d surface = place.unit() * (kEarthRadius + 0.05);
        const float distance =
            openvdb::tools::BoxSampler::sample(globe.solid->tree(), globe.solid->worldToIndex(surface));
        EXPECT_NEAR(distance, 0.05, 0.005) << place;
    }
    EXPECT_LT(globe.solid->tree().getValue(Coord(0)), 0);
}

TEST(Globe, TakesMemoryForTheShellAlone)
{
    const Globe globe = makeGlobe(0.04); // a dense box would have 37 million voxels
    EXPECT_LT(globe.domain->leafCount() * std::size_t(Domain::kLeafVoxels), 7'000'000u);
    for (auto leaf = globe.domain->topology().cbeginLeaf(); leaf; ++leaf)
        EXPECT_FALSE(leaf->isEmpty());
}

TEST(Globe, RefusesVoxelsThatAreTooSmallOrTooLarge)
{
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double voxelSize : {0.0, -0.1, 0.001, 0.6, 1e30, nan})
        EXPECT_THROW((void)makeGlobe(voxelSize), ParameterError) << voxelSize;
}

} // namespace
} // namespace vdblic
