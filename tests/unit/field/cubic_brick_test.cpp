#include "vdblic/field/cubic_brick.h"

#include "vdblic/field/frame_domain.h"
#include "vdblic/field/velocity_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

constexpr int kCoarse = 14; // voxels of the velocity along each axis, from -3
const Refinement kCubic{{2, 3, 5}, Interpolation::kCubic};

struct CubicField {
    openvdb::Vec3STree tree{Vec3f(0)};
    VelocityField field;

    explicit CubicField(const std::function<Vec3f(double, double, double)>& flow, const Coord& hole = {99, 99, 99})
    {
        auto topology = std::make_shared<openvdb::MaskTree>();
        for (auto voxel = openvdb::CoordBBox::createCube(Coord(-3), kCoarse).begin(); voxel; ++voxel) {
            if (*voxel == hole) continue;
            tree.setValue(*voxel, flow((*voxel)[0], (*voxel)[1], (*voxel)[2]));
            topology->setValueOn(*voxel);
        }
        const Velocities<Space::kVelocity, Per::kStep> level{tree, {openvdb::Mat3d::identity()}};
        field.build({std::make_shared<Domain>(kCubic.refined(*topology)), std::make_shared<Domain>(topology), kCubic},
                    level, level);
    }
};

/// Where a texture voxel lies in the velocity's index space.
openvdb::Vec3d coarsePosition(const Coord& voxel)
{
    openvdb::Vec3d position;
    for (int axis = 0; axis < 3; ++axis)
        position[axis] = (voxel[axis] + 0.5) / kCubic.factors[std::size_t(axis)] - 0.5;
    return position;
}

Float4 sampleAt(const VelocityField& field, const Coord& voxel)
{
    return field.sample(Float4{float(voxel[0]), float(voxel[1]), float(voxel[2]), 0}, 0.25f, Float4{99, 99, 99, 0});
}

TEST(CubicBrick, ReproducesQuadraticVelocitiesInside)
{
    const auto flow = [](double x, double y, double z) {
        return Vec3f(float(x * x - 3 * y), float(0.5 * y * y + z * x), float(z * z * 0.25 - x * y));
    };
    const CubicField cubic(flow);
    std::size_t compared = 0;
    for (auto voxel = cubic.field.domain().topology().cbeginValueOn(); voxel; ++voxel) {
        const openvdb::Vec3d at = coarsePosition(voxel.getCoord());
        if (at.x() < -2 || at.y() < -2 || at.z() < -2) continue; // within a voxel of the rim
        if (at.x() > kCoarse - 5 || at.y() > kCoarse - 5 || at.z() > kCoarse - 5) continue;
        const Vec3f expected = flow(at[0], at[1], at[2]);
        const Float4 found = sampleAt(cubic.field, voxel.getCoord());
        for (int axis = 0; axis < 3; ++axis)
            ASSERT_NEAR(found[axis], expected[axis] * float(kCubic.factors[std::size_t(axis)]), 1e-3) << at;
        ++compared;
    }
    EXPECT_GT(compared, 30000u);
}

/// At rims and around a hole the velocity continues as it is.
TEST(CubicBrick, KeepsAConstantVelocityEverywhere)
{
    const CubicField cubic([](double, double, double) { return Vec3f(1, -2, 0.5f); }, {4, 4, 4});
    for (auto voxel = cubic.field.domain().topology().cbeginValueOn(); voxel; ++voxel) {
        const Float4 found = sampleAt(cubic.field, voxel.getCoord());
        ASSERT_NEAR(found[0], 2, 1e-5) << voxel.getCoord();
        ASSERT_NEAR(found[1], -6, 1e-5) << voxel.getCoord();
        ASSERT_NEAR(found[2], 2.5, 1e-5) << voxel.getCoord();
    }
}

/// Keys' kernel with a = −½.
double keys(double distance)
{
    const double d = std::abs(distance);
    if (d < 1) return 1 + d * d * (1.5 * d - 2.5);
    return d < 2 ? 2 + d * (-4 + d * (2.5 - 0.5 * d)) : 0;
}

/// Away from the rim the velocity is the convolution of the 4³ next ones, whatever they are.
TEST(CubicBrick, ConvolvesWithKeysKernel)
{
    const auto flow = [](double x, double y, double z) {
        const double number = std::sin(12.9898 * x + 78.233 * y + 37.719 * z) * 43758.5453;
        return Vec3f(float(number - std::floor(number)), float(std::sin(x)), float(std::cos(y * z)));
    };
    const CubicField cubic(flow);
    for (auto voxel = openvdb::CoordBBox({-2, -3, -5}, {15, 23, 39}).begin(); voxel; ++voxel) {
        const openvdb::Vec3d at = coarsePosition(*voxel);
        const Coord first = Coord::floor(at).offsetBy(-1);
        openvdb::Vec3d expected(0);
        for (auto near = openvdb::CoordBBox::createCube(first, 4).begin(); near; ++near) {
            const openvdb::Vec3d away = at - (*near).asVec3d();
            expected += keys(away[0]) * keys(away[1]) * keys(away[2]) *
                        openvdb::Vec3d(flow((*near)[0], (*near)[1], (*near)[2]));
        }
        const Float4 found = sampleAt(cubic.field, *voxel);
        for (int axis = 0; axis < 3; ++axis)
            ASSERT_NEAR(found[axis] / float(kCubic.factors[std::size_t(axis)]), expected[axis], 2e-6) << at;
    }
}

} // namespace
} // namespace vdblic
