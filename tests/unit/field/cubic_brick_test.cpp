#include "vdblic/field/cubic_brick.h"

#include "vdblic/field/field_domain.h"
#include "vdblic/field/velocity_field.h"

#include <gtest/gtest.h>

#include <algorithm>
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
        const VelocityLevel level{tree, openvdb::Mat3d::identity()};
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

/// Linear interpolation bends at the velocity's voxels, cubic does not: second differences across them are smaller.
TEST(CubicBrick, HasNoBendsAtTheVelocitysVoxels)
{
    const auto flow = [](double x, double, double) { return Vec3f(float(std::sin(x)), 0, 0); };
    const CubicField cubic(flow);
    double most = 0;
    for (int x = 2; x < 14; ++x) { // texture voxels, two in a voxel of the velocity
        const auto at = [&](int i) { return double(sampleAt(cubic.field, {i, 3, 5})[0]) / 2; };
        most = std::max(most, std::abs(at(x) - std::sin((x + 0.5) / 2 - 0.5)));
    }
    EXPECT_LT(most, 0.03); // linear: 0.09
}

} // namespace
} // namespace vdblic
