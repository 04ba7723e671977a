#include "vdblic/core/errors.h"
#include "vdblic/field/synth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Vec3d;

const Vec3d kExtents[] = {{1, 1, 1}, {1.8, 0.9, 1}, {0.5, 1, 3}};

/// Positions in a box, away from its symmetry planes and its walls.
std::vector<Vec3d> positionsIn(const Vec3d& extent)
{
    std::vector<Vec3d> positions;
    for (int i = 0; i < 9 * 9 * 9; ++i) {
        const int x = i / 81, y = i / 9 % 9, z = i % 9;
        positions.push_back(Vec3d((x + 0.43) / 9 - 0.5, (y + 0.51) / 9 - 0.5, (z + 0.57) / 9 - 0.5) * extent);
    }
    return positions;
}

Vec3d velocityOf(const char* flow, const Vec3d& position, double time, const Vec3d& extent = Vec3d(1))
{
    return findAnalyticFlow(flow).make(extent)(position, time);
}

void expectNear(const Vec3d& a, const Vec3d& b, double tolerance)
{
    EXPECT_LT((a - b).length(), tolerance) << a << " " << b;
}

TEST(AnalyticFlow, DivergenceIsZero)
{
    constexpr double kStep = 1e-6; // small, so that no difference spans the kink at the ring's surface
    for (const AnalyticFlow& flow : analyticFlows()) {
        if (flow.isOnGlobe) continue;
        for (const Vec3d& extent : kExtents) {
            const FlowFunction velocity = flow.make(extent);
            for (const double time : {0.0, 0.37, 5.2}) {
                double divergence = 0, gradient = 0;
                for (const Vec3d& position : positionsIn(extent)) {
                    double sum = 0;
                    for (int axis = 0; axis < 3; ++axis) {
                        Vec3d step(0);
                        step[axis] = kStep;
                        const Vec3d slope =
                            (velocity(position + step, time) - velocity(position - step, time)) / (2 * kStep);
                        sum += slope[axis];
                        gradient = std::max(gradient, slope.length());
                    }
                    divergence = std::max(divergence, std::abs(sum));
                }
                EXPECT_LT(divergence, 1e-7 * (1 + gradient)) << flow.name << " " << extent << " " << time;
            }
        }
    }
}

TEST(AnalyticFlow, TypicalSpeedIsOne)
{
    for (const AnalyticFlow& flow : analyticFlows()) {
        if (flow.isOnGlobe) continue;
        for (const Vec3d& extent : {kExtents[0], kExtents[1]}) {
            const FlowFunction velocity = flow.make(extent);
            double sum = 0;
            const std::vector<Vec3d> positions = positionsIn(extent);
            for (const Vec3d& position : positions)
                sum += velocity(position, 0.6).length();
            EXPECT_GT(sum / double(positions.size()), 0.67) << flow.name << " " << extent;
            EXPECT_LT(sum / double(positions.size()), 1.33) << flow.name << " " << extent;
        }
    }
}

TEST(AnalyticFlow, UnsteadyFlowsChange)
{
    for (const AnalyticFlow& flow : analyticFlows()) {
        if (flow.isOnGlobe) continue;
        const FlowFunction velocity = flow.make(Vec3d(1));
        const bool steady = flow.name == "uniform" || flow.name == "rotation";
        const Vec3d position(0.21, 0.13, 0.34);
        EXPECT_EQ(velocity(position, 0.1) == velocity(position, 0.4), steady) << flow.name;
    }
}

TEST(AnalyticFlow, KnownValuesOfUniformAndRotation)
{
    expectNear(velocityOf("uniform", {0.3, -0.2, 0.1}, 3), Vec3d(6.0 / 7, 3.0 / 7, 2.0 / 7), 1e-15);
    const double rate = std::sqrt(6.0);
    expectNear(velocityOf("rotation", {0.5, 0.25, -0.4}, 3), Vec3d(-0.25, 0.5, 0) * rate, 1e-15);
}

TEST(AnalyticFlow, KnownValuesOfAbc)
{
    // At the centre all angles are sin πt; at t = 0 and 1 they are 0, at t = ½ they are 1.
    const double a = std::sqrt(1.0 / 2), b = std::sqrt(1.0 / 3), c = std::sqrt(1.0 / 6);
    expectNear(velocityOf("abc", Vec3d(0), 0), Vec3d(c, a, b), 1e-14);
    expectNear(velocityOf("abc", Vec3d(0), 1), Vec3d(c, a, b), 1e-14);
    expectNear(
        velocityOf("abc", Vec3d(0), 0.5),
        Vec3d(a * std::sin(1) + c * std::cos(1), b * std::sin(1) + a * std::cos(1), c * std::sin(1) + b * std::cos(1)),
        1e-14);
    // A Beltrami flow: its curl is 2π times itself.
    const Vec3d position(0.13, -0.27, 0.4);
    constexpr double kStep = 1e-4;
    const auto slope = [&](int component, int axis) {
        Vec3d step(0);
        step[axis] = kStep;
        return (velocityOf("abc", position + step, 0.3) - velocityOf("abc", position - step, 0.3))[component] /
               (2 * kStep);
    };
    const Vec3d curl(slope(2, 1) - slope(1, 2), slope(0, 2) - slope(2, 0), slope(1, 0) - slope(0, 1));
    expectNear(curl, 2 * std::numbers::pi * velocityOf("abc", position, 0.3), 1e-5);
}

TEST(AnalyticFlow, TornadoHasTheLambOseenProfileAboutItsAxis)
{
    // At the box's middle height and t = 0 the axis passes (0.12, 0).
    const Vec3d axis(0.12, 0, 0);
    const double follows = 0.12 * std::numbers::pi; // ∂axis/∂z, along y
    expectNear(velocityOf("tornado", axis, 0), Vec3d(0, 1.5 * follows, 1.5), 1e-14);
    for (const double r : {0.05, 0.1, 0.3}) {
        const double updraft = 1.5 * std::exp(-r * r / 0.01);
        const double swirl = 0.3 / r * (1 - std::exp(-r * r / 0.01));
        expectNear(velocityOf("tornado", axis + Vec3d(r, 0, 0), 0), Vec3d(0, swirl + updraft * follows, updraft),
                   1e-14);
        expectNear(velocityOf("tornado", axis + Vec3d(0, r, 0), 0), Vec3d(-swirl, updraft * follows, updraft), 1e-14);
    }
    // Half a unit of time later the axis has turned by a quarter.
    expectNear(velocityOf("tornado", {0, 0.12, 0}, 0.5), Vec3d(-1.5 * follows, 0, 1.5), 1e-14);
}

TEST(AnalyticFlow, GyreDoesNotPassItsWalls)
{
    for (const Vec3d& extent : kExtents) {
        const FlowFunction velocity = findAnalyticFlow("gyre").make(extent);
        for (const Vec3d& position : positionsIn(extent)) {
            for (int axis = 0; axis < 3; ++axis) {
                for (const double side : {-0.5, 0.5}) {
                    Vec3d wall = position;
                    wall[axis] = side * extent[axis];
                    ASSERT_NEAR(velocity(wall, 0.8)[axis], 0, 1e-12) << wall;
                }
            }
        }
    }
}

TEST(AnalyticFlow, GyreSeparatorMovesAsPublished)
{
    // Shadden et al.: on the lower wall the two gyres meet where f = 1, that is at x = 1 when sin ωt = 0, elsewhere
    // at the root of ε s x² + (1 − 2 ε s) x = 1; here x counts from −1 to 1 over the box and ε = ¼.
    for (const double time : {0.0, 0.25, 0.5, 1.5}) {
        const double q = 0.25 * std::sin(std::numbers::pi * time);
        const double x = q == 0 ? 1 : (-(1 - 2 * q) + std::sqrt((1 - 2 * q) * (1 - 2 * q) + 4 * q)) / (2 * q);
        const auto along = [&](double offset) {
            return velocityOf("gyre", {(x - 1 + offset) / 2, -0.5, 0.1}, time).x();
        };
        EXPECT_NEAR(along(0), 0, 1e-12) << time;
        EXPECT_LT(along(-0.05), 0);
        EXPECT_GT(along(0.05), 0);
    }
}

TEST(AnalyticFlow, RingIsContinuousAndStillFarAway)
{
    const FlowFunction velocity = findAnalyticFlow("ring").make(Vec3d(1));
    // At t = 0 the sphere of radius 0.36 sits at the centre: 3/2 at the centre, 0 at its poles.
    expectNear(velocity(Vec3d(0), 0), Vec3d(0, 0, 1.5), 1e-14);
    expectNear(velocity({0, 0, 0.36}, 0), Vec3d(0), 1e-12);
    expectNear(velocity({0.36, 0, 0}, 0), Vec3d(0, 0, -1.5), 1e-12);
    expectNear(velocity({30, 40, 50}, 0), Vec3d(0, 0, -1), 1e-5);
    for (const Vec3d& direction : {Vec3d(1, 2, 3), Vec3d(-3, 1, -1), Vec3d(0, -1, 4)}) {
        const Vec3d surface = 0.36 * direction.unit();
        const Vec3d inside = velocity(surface * (1 - 1e-9), 0), outside = velocity(surface * (1 + 1e-9), 0);
        expectNear(inside, outside, 1e-7);
        EXPECT_NEAR(outside.dot(direction.unit()), 0, 1e-7); // nothing leaves the sphere
    }
    // Half a unit of time later the sphere has the same radius and its largest offset.
    expectNear(velocity({0, 0, 0.15}, 0.5), Vec3d(0, 0, 1.5), 1e-12);
}

TEST(FlowInBox, IsScaledToTheMiddleSide)
{
    const AnalyticFlow& rotation = findAnalyticFlow("rotation");
    const BoxSize size{60, 20, 40};
    const FlowFunction world = flowInBox(rotation, size, 0.5);
    const FlowFunction plain = rotation.make(Vec3d(1.5, 0.5, 1));
    const Vec3d centre(14.75, 4.75, 9.75); // of the voxels 0 … 59, 0 … 19, 0 … 39
    expectNear(world(centre, 1), Vec3d(0), 1e-12);
    expectNear(world(centre + Vec3d(3, -2, 7), 1), 36 * plain(Vec3d(3, -2, 7) / 20, 0), 1e-12);
    // Twice the voxels at half the size: the same box, half the speed, so changes take twice as long.
    const FlowFunction coarse = flowInBox(findAnalyticFlow("abc"), {10, 12, 20}, 1);
    const FlowFunction fine = flowInBox(findAnalyticFlow("abc"), {20, 24, 40}, 0.5);
    expectNear(coarse({3, 4, 5}, 0.2), 2 * fine(Vec3d(3, 4, 5) + Vec3d(0.25), 0.4), 1e-10);
}

TEST(FlowInBox, RefusesBadNumbersAndNames)
{
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const AnalyticFlow& flow = findAnalyticFlow("abc");
    EXPECT_THROW((void)findAnalyticFlow("ABC"), ParameterError);
    EXPECT_THROW((void)flowInBox(findAnalyticFlow("rossby"), {8, 8, 8}, 1), ParameterError);
    EXPECT_THROW((void)flowInBox(flow, {0, 1, 1}, 1), ParameterError);
    EXPECT_THROW((void)flowInBox(flow, {100000, 100000, 1000}, 1), ParameterError);
    for (const double voxelSize : {0.0, -1.0, nan, 1e30, 1e-30}) {
        EXPECT_THROW((void)flowInBox(flow, {8, 8, 8}, voxelSize), ParameterError) << voxelSize;
    }
    const SynthParams good{.flow = "abc", .output = "%d.vdb", .size = {{8, 8, 8}}, .frames = "1-9"};
    EXPECT_NO_THROW(good.validate());
    for (const double dt : {0.0, -1.0, nan, std::numeric_limits<double>::infinity(), 1e6}) {
        SynthParams bad = good;
        bad.dt = dt;
        EXPECT_THROW(bad.validate(), ParameterError) << dt;
    }
    SynthParams boxless = good;
    boxless.size.reset();
    EXPECT_THROW(boxless.validate(), ParameterError);
    boxless.flow = "rossby";
    EXPECT_NO_THROW(boxless.validate());
    boxless.size = good.size;
    EXPECT_THROW(boxless.validate(), ParameterError);
}

TEST(SampleFlow, GivesEachActiveVoxelTheVelocityAtItsCentre)
{
    const auto topology = std::make_shared<openvdb::MaskTree>();
    for (int i = -9; i < 30; ++i)
        topology->setValueOn({i, -i * i % 23, 2 * i});
    const Domain domain(topology);
    const auto transform = openvdb::math::Transform::createLinearTransform(0.5);
    transform->postTranslate({1, 2, 3});
    const auto grid = sampleFlow([](const Vec3d& p, double t) { return Vec3d(p.x() + t, p.y() * p.z(), p.z()); },
                                 domain, *transform, 0.25);
    EXPECT_EQ(grid->getName(), "velocity");
    EXPECT_EQ(grid->getVectorType(), openvdb::VEC_CONTRAVARIANT_RELATIVE);
    EXPECT_EQ(grid->transform(), *transform);
    EXPECT_TRUE(grid->tree().hasSameTopology(domain.topology()));
    for (auto voxel = grid->cbeginValueOn(); voxel; ++voxel) {
        const Vec3d p = 0.5 * voxel.getCoord().asVec3d() + Vec3d(1, 2, 3);
        EXPECT_EQ(*voxel, openvdb::Vec3f(Vec3d(p.x() + 0.25, p.y() * p.z(), p.z()))) << voxel.getCoord();
    }
}

} // namespace
} // namespace vdblic
