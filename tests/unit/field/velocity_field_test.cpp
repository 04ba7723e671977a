#include "vdblic/field/velocity_field.h"

#include "vdblic/field/box_domain.h"

#include <openvdb/tools/Interpolation.h>

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

const Float4 kOutside = {-77, -78, -79, -80};
const openvdb::Mat3d kIdentity = openvdb::Mat3d::identity();

/// A tree of velocities given by a function of the index.
template<typename Function>
openvdb::Vec3STree velocitiesOn(const Domain& domain, const Function& function)
{
    openvdb::Vec3STree tree(domain.topology(), Vec3f(0), openvdb::TopologyCopy());
    for (auto voxel = tree.beginValueOn(); voxel; ++voxel)
        voxel.setValue(function(voxel.getCoord()));
    return tree;
}

VelocityField fieldOf(std::shared_ptr<const Domain> domain, const openvdb::Vec3STree& start,
                      const openvdb::Vec3STree& end)
{
    VelocityField field;
    field.build(std::move(domain), {start, kIdentity}, {end, kIdentity});
    return field;
}

Float4 at(double x, double y, double z)
{
    return Float4{float(x), float(y), float(z), 0};
}

void expectNear(Float4 sampled, const Vec3f& expected, float tolerance, const char* what = "")
{
    for (int axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(sampled[axis], expected[axis], tolerance) << what << " axis " << axis;
    EXPECT_EQ(sampled[3], 0) << what;
}

bool isOutside(Float4 sampled)
{
    return sampled[0] == kOutside[0] && sampled[3] == kOutside[3];
}

Vec3f linearFlow(const Coord& c)
{
    const Vec3f p(c.asVec3s());
    return {1 + 0.25f * p.x() - 0.5f * p.y(), 2 * p.z() - p.x(), 3 - p.y() + 0.125f * p.z()};
}

Vec3f linearFlow(const openvdb::Vec3d& p)
{
    return {float(1 + 0.25 * p.x() - 0.5 * p.y()), float(2 * p.z() - p.x()), float(3 - p.y() + 0.125 * p.z())};
}

TEST(VelocityField, IsExactOnALinearField)
{
    const auto topology = std::make_shared<openvdb::MaskTree>();
    topology->fill(openvdb::CoordBBox(Coord(-19, -13, -9), Coord(12, 20, 17)), true);
    const auto domain = std::make_shared<const Domain>(topology);
    const openvdb::Vec3STree tree = velocitiesOn(*domain, [](const Coord& c) { return linearFlow(c); });
    const VelocityField field = fieldOf(domain, tree, tree);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> x(-19, 12), y(-13, 20), z(-9, 17);
    for (int i = 0; i < 5000; ++i) {
        const openvdb::Vec3d p(x(random), y(random), z(random));
        expectNear(field.sample(at(p.x(), p.y(), p.z()), 0.5f, kOutside), linearFlow(p), 2e-5f);
    }
    // On voxel centres the values themselves come back.
    for (const Coord& c : {Coord(-19, -13, -9), Coord(12, 20, 17), Coord(0, 0, 0), Coord(-8, 7, 8), Coord(-1, 8, -9)}) {
        expectNear(field.sample(at(c.x(), c.y(), c.z()), 0, kOutside), linearFlow(c), 0);
    }
}

TEST(VelocityField, AgreesWithOpenVdbInTheInterior)
{
    // Between the outermost voxel centres every sample has its eight corners.
    const auto topology = std::make_shared<openvdb::MaskTree>();
    topology->fill(openvdb::CoordBBox(Coord(-21, -10, -33), Coord(22, 30, 9)), true);
    const auto domain = std::make_shared<const Domain>(topology);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> value(-4, 4), fraction(0, 1);
    const auto randomValue = [&](const Coord&) { return Vec3f(value(random), value(random), value(random)); };
    const openvdb::Vec3STree start = velocitiesOn(*domain, randomValue), end = velocitiesOn(*domain, randomValue);
    const VelocityField field = fieldOf(domain, start, end);
    std::uniform_real_distribution<double> x(-21, 22), y(-10, 30), z(-33, 9);
    for (int i = 0; i < 5000; ++i) {
        const Float4 position = at(x(random), y(random), z(random));
        const openvdb::Vec3d p(position[0], position[1], position[2]);
        const float time = fraction(random);
        Vec3f a, b;
        openvdb::tools::BoxSampler::sample(start, p, a);
        openvdb::tools::BoxSampler::sample(end, p, b);
        expectNear(field.sample(position, time, kOutside), a + (b - a) * time, 2e-5f);
    }
}

TEST(VelocityField, IsLinearInTime)
{
    const auto domain = boxDomain({8, 8, 8});
    const openvdb::Vec3STree start = velocitiesOn(*domain, [](const Coord&) { return Vec3f(4, 0, -8); });
    const openvdb::Vec3STree end = velocitiesOn(*domain, [](const Coord&) { return Vec3f(8, 4, 8); });
    const VelocityField field = fieldOf(domain, start, end);
    expectNear(field.sample(at(3.5, 2.25, 1), 0, kOutside), {4, 0, -8}, 0);
    expectNear(field.sample(at(3.5, 2.25, 1), 0.25f, kOutside), {5, 1, -4}, 0);
    expectNear(field.sample(at(3.5, 2.25, 1), 0.5f, kOutside), {6, 2, 0}, 0);
    expectNear(field.sample(at(3.5, 2.25, 1), 1, kOutside), {8, 4, 8}, 0);
}

TEST(VelocityField, TurnsStoredValuesIntoVoxelsPerStep)
{
    const auto domain = boxDomain({8, 8, 8});
    const openvdb::Vec3STree tree = velocitiesOn(*domain, [](const Coord&) { return Vec3f(1, 2, 3); });
    VelocityField field;
    const openvdb::Mat3d turned(0.0, -2.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.5);
    field.build(domain, {tree, turned}, {tree, kIdentity * 3.0});
    expectNear(field.sample(at(4, 4, 4), 0, kOutside), {-4, 2, 1.5}, 0);
    expectNear(field.sample(at(4, 4, 4), 1, kOutside), {3, 6, 9}, 0);
}

TEST(VelocityField, AVoxelOfOneFrameKeepsItsVelocity)
{
    const auto domain = boxDomain({8, 8, 8});
    const openvdb::Vec3STree both = velocitiesOn(*domain, [](const Coord&) { return Vec3f(2, 0, 0); });
    openvdb::Vec3STree half(Vec3f(0));
    half.fill(openvdb::CoordBBox(Coord(0), Coord(3, 7, 7)), Vec3f(6, 4, 0));
    const VelocityField appears = fieldOf(domain, half, both), vanishes = fieldOf(domain, both, half);
    // Only the later frame has a velocity at x = 6; only the earlier one in the field that vanishes.
    for (const float time : {0.25f, 0.5f, 0.75f}) {
        expectNear(appears.sample(at(6, 3, 3), time, kOutside), {2, 0, 0}, 0);
        expectNear(vanishes.sample(at(6, 3, 3), time, kOutside), {2, 0, 0}, 0);
    }
    // Between two velocities the field is linear in time.
    expectNear(appears.sample(at(1, 3, 3), 0.25f, kOutside), {5, 3, 0}, 0);
    expectNear(vanishes.sample(at(1, 3, 3), 0.25f, kOutside), {3, 1, 0}, 0);
    // At the moment of the frame without a velocity the voxel is outside the field.
    EXPECT_TRUE(isOutside(appears.sample(at(6, 3, 3), 0, kOutside)));
    EXPECT_TRUE(isOutside(vanishes.sample(at(6, 3, 3), 1, kOutside)));
}

TEST(VelocityField, ContinuesTheLastVoxelsOverTheRim)
{
    const auto topology = std::make_shared<openvdb::MaskTree>();
    topology->fill(openvdb::CoordBBox(Coord(-8), Coord(7)), true);
    const auto domain = std::make_shared<const Domain>(topology);
    const openvdb::Vec3STree tree = velocitiesOn(*domain, [](const Coord& c) { return linearFlow(c); });
    const VelocityField field = fieldOf(domain, tree, tree);
    // A voxel reaches half a voxel beyond its centre, at both ends; velocity is that of the nearest centre.
    for (const auto& [beyondRim, clamped] :
         {std::pair(7.25, 7.0), std::pair(7.49, 7.0), std::pair(-8.25, -8.0), std::pair(-8.5, -8.0)}) {
        for (const double other : {-8.0, -3.5, -0.25, 0.0, 6.75}) { // −0.25: where two leaves meet
            expectNear(field.sample(at(beyondRim, other, 1), 0, kOutside),
                       linearFlow(openvdb::Vec3d(clamped, other, 1)), 1e-5f, "x");
            expectNear(field.sample(at(other, beyondRim, 1), 0, kOutside),
                       linearFlow(openvdb::Vec3d(other, clamped, 1)), 1e-5f, "y");
            expectNear(field.sample(at(1, other, beyondRim), 0, kOutside),
                       linearFlow(openvdb::Vec3d(1, other, clamped)), 1e-5f, "z");
        }
        expectNear(field.sample(at(beyondRim, beyondRim, beyondRim), 0, kOutside),
                   linearFlow(openvdb::Vec3d(clamped, clamped, clamped)), 1e-5f, "corner");
    }
    for (const double beyond : {-8.75, -9.0, -200.0, 8.0, 8.5, 200.0}) {
        EXPECT_TRUE(isOutside(field.sample(at(beyond, 0, 0), 0, kOutside))) << beyond;
        EXPECT_TRUE(isOutside(field.sample(at(0, beyond, 0), 0, kOutside))) << beyond;
        EXPECT_TRUE(isOutside(field.sample(at(0, 0, beyond), 0, kOutside))) << beyond;
    }
}

TEST(VelocityField, ContinuesActiveVoxelsOverHoles)
{
    // One active voxel alone: its velocity holds in all cells around it.
    const auto topology = std::make_shared<openvdb::MaskTree>();
    topology->setValueOn(Coord(3, 3, 3));
    const auto domain = std::make_shared<const Domain>(topology);
    const openvdb::Vec3STree tree = velocitiesOn(*domain, [](const Coord&) { return Vec3f(1, 2, 3); });
    const VelocityField field = fieldOf(domain, tree, tree);
    expectNear(field.sample(at(3, 3, 3), 0.5f, kOutside), {1, 2, 3}, 0);
    expectNear(field.sample(at(3.25, 2.5, 3.75), 0.5f, kOutside), {1, 2, 3}, 1e-6f);
    EXPECT_TRUE(isOutside(field.sample(at(5, 3, 3), 0.5f, kOutside)));
    EXPECT_TRUE(isOutside(field.sample(at(4, 3, 3), 0.5f, kOutside)));
}

TEST(VelocityField, CanBeBuiltAgainOnAnotherDomain)
{
    VelocityField field;
    for (const int side : {20, 4, 30}) {
        const auto domain = boxDomain({side, side, side});
        const openvdb::Vec3STree tree = velocitiesOn(*domain, [&](const Coord&) { return Vec3f(float(side)); });
        field.build(domain, {tree, kIdentity}, {tree, kIdentity});
        expectNear(field.sample(at(side - 1, 0.5, side - 1.5), 0.5f, kOutside), Vec3f(float(side)), 0);
        EXPECT_TRUE(isOutside(field.sample(at(side + 9, 0, 0), 0.5f, kOutside)));
    }
}

TEST(VisitBrick, SeesTheVoxelsOfAllEightLeavesAndTiles)
{
    openvdb::FloatTree tree(-5);
    for (int i = 0; i < 16 * 16 * 16; ++i) {
        const Coord c = Coord(i / 256, i / 16 % 16, i % 16).offsetBy(-8);
        tree.setValue(c, float(i));
    }
    tree.addTile(1, Coord(-8, -8, 0), 7, true); // instead of a leaf
    tree.addTile(1, Coord(0, 0, 0), 9, false);  // at the far corner
    std::vector<int> visits(Bricks::kSize, 0);
    visitBrick(tree, Coord(-8), [&](int record, float value, bool active) {
        ++visits[std::size_t(record)];
        const Coord c = Coord(record / 81, record / 9 % 9, record % 9).offsetBy(-8);
        ASSERT_EQ(value, tree.getValue(c)) << c;
        ASSERT_EQ(active, tree.isValueOn(c)) << c;
    });
    EXPECT_EQ(visits, std::vector<int>(Bricks::kSize, 1));
}

} // namespace
} // namespace vdblic
