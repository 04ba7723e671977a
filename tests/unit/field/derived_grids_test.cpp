#include "vdblic/field/derived_grids.h"

#include "vdblic/core/errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Mat3d;
using openvdb::Mat4d;
using openvdb::Vec3d;

const std::vector<std::string> kBoth = {"vorticity", "q"};

/// Voxels of 0.5 x 2 x 0.25, rotated, moved and mirrored.
openvdb::math::Transform::Ptr skewed()
{
    auto matrix = openvdb::math::scale<Mat4d>(Vec3d(0.5, 2, -0.25));
    matrix.postRotate(openvdb::math::X_AXIS, 0.7);
    matrix.postRotate(openvdb::math::Z_AXIS, -1.1);
    matrix.postTranslate(Vec3d(3, -7, 11));
    return openvdb::math::Transform::createLinearTransform(matrix);
}

/// A world velocity on a box of voxels.
openvdb::Vec3SGrid::Ptr sampled(const openvdb::math::Transform& transform, int size,
                                const std::function<Vec3d(const Vec3d&)>& velocity)
{
    auto grid = openvdb::Vec3SGrid::create();
    grid->setTransform(transform.copy());
    for (auto i = openvdb::CoordBBox::createCube(Coord(-3), size).begin(); i; ++i)
        grid->tree().setValueOn(*i, openvdb::Vec3f(velocity(transform.indexToWorld(*i))));
    return grid;
}

Domain domainOf(const openvdb::Vec3SGrid& grid)
{
    return Domain(std::make_shared<openvdb::MaskTree>(grid.tree(), false, true, openvdb::TopologyCopy()));
}

std::vector<openvdb::FloatGrid::Ptr> derive(const openvdb::Vec3SGrid& grid)
{
    return derivedGrids(kBoth, domainOf(grid), grid, {Mat3d::identity()});
}

void expectAll(const openvdb::FloatGrid& grid, double value, double tolerance)
{
    for (auto i = grid.cbeginValueOn(); i; ++i)
        EXPECT_NEAR(*i, value, tolerance) << grid.getName() << " at " << i.getCoord();
}

TEST(DerivedGrids, ARigidRotationHasTwiceItsAngularVelocity)
{
    const Vec3d omega(0.3, -1.2, 0.7);
    const auto grid = sampled(*skewed(), 11, [&](const Vec3d& x) { return omega.cross(x - Vec3d(1, 2, 3)); });
    const auto derived = derive(*grid);
    expectAll(*derived[0], 2 * omega.length(), 2e-4);
    expectAll(*derived[1], omega.lengthSqr(), 2e-4);
}

TEST(RotationShare, SeparatesRotationFromLaminarFlow)
{
    const auto share = [](const std::function<Vec3d(const Vec3d&)>& velocity) {
        return rotationShare(*sampled(*skewed(), 11, velocity), {Mat3d::identity() * 3.0});
    };
    EXPECT_NEAR(share([](const Vec3d& x) { return Vec3d(-x.y(), x.x(), 0.2); }), 1, 1e-4);
    EXPECT_NEAR(share([](const Vec3d& x) { return Vec3d(-2 * x.y(), x.x(), 0); }), 0.8, 1e-3); // q 2, ½|J|² 2.5
    EXPECT_NEAR(share([](const Vec3d& x) { return Vec3d(1.5 * x.y(), 0, 0); }), 0, 1e-4);
    EXPECT_EQ(share([](const Vec3d& x) { return Vec3d(x.x(), -x.y(), 0); }), 0);
    EXPECT_EQ(share([](const Vec3d&) { return Vec3d(1, 2, 3); }), 0);
    EXPECT_EQ(share([](const Vec3d& x) { return Vec3d(1, 1e-4 * std::sin(91 * x.x()), 1e-4 * std::sin(83 * x.y())); }),
              0);
    EXPECT_EQ(rotationShare(*openvdb::Vec3SGrid::create(), {Mat3d::identity()}), 0);
}

TEST(DerivedGrids, ALinearShearHasVorticityButNoExcessOfRotation)
{
    const auto grid = sampled(*skewed(), 11, [](const Vec3d& x) { return Vec3d(1.5 * x.y(), 0, 0); });
    const auto derived = derive(*grid);
    expectAll(*derived[0], 1.5, 2e-4);
    expectAll(*derived[1], 0, 2e-4);
}

TEST(DerivedGrids, AStrainHasNoVorticity)
{
    const auto grid = sampled(*skewed(), 11, [](const Vec3d& x) { return Vec3d(2 * x.x(), -x.y(), -x.z()); });
    const auto derived = derive(*grid);
    expectAll(*derived[0], 0, 4e-4);
    expectAll(*derived[1], -0.5 * (4 + 1 + 1), 1e-3);
}

TEST(DerivedGrids, AreOfSecondOrderOnTheAbcFlow)
{
    // Curl and velocity of this flow are equal.
    constexpr double kA = 1, kB = 0.7, kC = 0.43;
    const auto velocity = [](const Vec3d& x) {
        return Vec3d(kA * std::sin(x.z()) + kC * std::cos(x.y()), kB * std::sin(x.x()) + kA * std::cos(x.z()),
                     kC * std::sin(x.y()) + kB * std::cos(x.x()));
    };
    const auto exactQ = [](const Vec3d& x) {
        return kC * std::sin(x.y()) * kB * std::cos(x.x()) + kA * std::cos(x.z()) * kB * std::sin(x.x()) +
               kA * std::sin(x.z()) * kC * std::cos(x.y());
    };
    double errors[2][2] = {}; // by voxel size and quantity
    for (int level = 0; level < 2; ++level) {
        const auto transform = openvdb::math::Transform::createLinearTransform(level == 0 ? 0.2 : 0.1);
        const auto derived = derive(*sampled(*transform, level == 0 ? 15 : 29, velocity));
        for (int i = 0; i < (level == 0 ? 9 : 17); ++i) {
            const Coord at(i, 2 * i / 3, i / 2); // away from the rim
            const Vec3d x = transform->indexToWorld(at);
            const double expected[] = {velocity(x).length(), exactQ(x)};
            for (int j = 0; j < 2; ++j)
                errors[level][j] = std::max(errors[level][j], std::abs(derived[j]->tree().getValue(at) - expected[j]));
        }
    }
    for (int j = 0; j < 2; ++j) {
        EXPECT_LT(errors[0][j], 0.02) << kBoth[j];
        EXPECT_NEAR(errors[0][j] / errors[1][j], 4, 0.8) << kBoth[j];
    }
}

TEST(DerivedGrids, AreExactAtRimsAndHolesOfALinearField)
{
    const Vec3d omega(0, 0, 2);
    auto grid = sampled(*openvdb::math::Transform::createLinearTransform(0.1), 8,
                        [&](const Vec3d& x) { return omega.cross(x); });
    for (const Coord& hole : {Coord(0, 0, 0), Coord(1, 0, 0), Coord(-3, -3, -3)})
        grid->tree().setValueOff(hole, openvdb::Vec3f(1000));
    const auto derived = derive(*grid);
    EXPECT_EQ(derived[0]->activeVoxelCount(), 512u - 3);
    EXPECT_EQ(derived[0]->transform(), grid->transform());
    expectAll(*derived[0], 4, 1e-4);
    expectAll(*derived[1], 4, 1e-4);
}

TEST(DerivedGrids, LookBeyondACutDomainAndAreZeroOnALonelyVoxel)
{
    // A parabola: at the cut, only central differences give its slope.
    const auto grid = sampled(*openvdb::math::Transform::createLinearTransform(1.0), 9,
                              [](const Vec3d& x) { return Vec3d(0, x.x() * x.x(), 0); });
    auto cut = std::make_shared<openvdb::MaskTree>();
    cut->setValueOn(Coord(2, 0, 0));
    const auto derived = derivedGrids(kBoth, Domain(cut), *grid, {Mat3d::identity()});
    EXPECT_EQ(derived[0]->activeVoxelCount(), 1u);
    EXPECT_NEAR(derived[0]->tree().getValue(Coord(2, 0, 0)), 4, 1e-5);

    auto lonely = openvdb::Vec3SGrid::create();
    lonely->tree().setValueOn(Coord(5), openvdb::Vec3f(1, 2, 3));
    EXPECT_EQ(derive(*lonely)[0]->tree().getValue(Coord(5)), 0);
}

TEST(DerivedGrids, UseTheVelocitysUnit)
{
    const auto grid = sampled(*openvdb::math::Transform::createLinearTransform(0.5), 6,
                              [](const Vec3d& x) { return Vec3d(0, 0, 3 * x.x()); });
    const auto derived = derivedGrids({"vorticity"}, domainOf(*grid), *grid, {Mat3d::identity() * 2.5});
    ASSERT_EQ(derived.size(), 1u);
    EXPECT_EQ(derived[0]->getName(), "vorticity");
    expectAll(*derived[0], 7.5, 1e-4);
}

TEST(DerivedGrids, RefuseUnknownAndRepeatedNames)
{
    EXPECT_THROW(checkDerivedNames({"helicity"}), ParameterError);
    EXPECT_THROW(checkDerivedNames({""}), ParameterError);
    EXPECT_THROW(checkDerivedNames({"q", "q"}), ParameterError);
    EXPECT_NO_THROW(checkDerivedNames({"q", "vorticity"}));
}

} // namespace
} // namespace vdblic
