#include "vdblic/field/mix_bits.h"
#include "vdblic/field/refinement.h"
#include "vdblic/field/resample.h"
#include "vdblic/field/trilinear.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3d;

TEST(Resampled, IsExactForALinearGridInsideAndContinuesItAtTheRim)
{
    const auto linear = [](const Vec3d& p) { return 1 + 2 * p[0] - p[1] + 0.5 * p[2]; };
    const auto values = openvdb::FloatGrid::create(0);
    values->setName("magnitude");
    values->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    for (auto voxel = openvdb::CoordBBox({-4, -4, -4}, {5, 5, 5}).begin(); voxel; ++voxel)
        values->tree().setValue(*voxel, float(linear((*voxel).asVec3d())));

    const Refinement refinement{{3, 2, 4}};
    const auto like = openvdb::FloatGrid::create(0);
    like->setTransform(refinement.refined(values->transform()));
    for (const Coord& voxel : {Coord(0, 0, 0), Coord(-7, 5, 9), Coord(17, 11, 23), Coord(300, 0, 0)})
        like->tree().setValue(voxel, 1);
    const auto found = resampled(*values, *like);
    EXPECT_EQ(found->getName(), "magnitude");
    EXPECT_EQ(found->activeVoxelCount(), 4u);
    EXPECT_EQ(found->transform(), like->transform());
    for (const Coord& voxel : {Coord(0, 0, 0), Coord(-7, 5, 9)}) {
        const Vec3d position = values->worldToIndex(like->indexToWorld(voxel));
        EXPECT_NEAR(found->tree().getValue(voxel), linear(position), 1e-5);
    }
    EXPECT_NEAR(found->tree().getValue({17, 11, 23}), linear({5, 5, 5}), 1e-5); // the last corner alone
    EXPECT_EQ(found->tree().getValue({300, 0, 0}), 0);
}

TEST(Resampled, HasTheBitsOfTheInterpolationAtEachVoxel)
{
    const auto values = openvdb::FloatGrid::create(0);
    for (auto voxel = openvdb::CoordBBox({-9, -3, -5}, {11, 9, 12}).begin(); voxel; ++voxel) {
        const Coord& c = *voxel;
        if (mixBits(std::uint64_t(c.hash())) % 4 > 0) values->tree().setValue(c, std::sin(float(c.hash() % 1000)));
    }
    values->tree().addTile(1, Coord(16, 0, 0), 0.7f, true);
    const auto accessor = values->getConstAccessor();
    for (const auto& factors : {std::array{1, 1, 1}, std::array{3, 2, 4}, std::array{1, 16, 5}}) {
        const Refinement refinement{factors};
        const auto like = openvdb::FloatGrid::create(0);
        like->setTransform(refinement.refined(values->transform()));
        like->setTree(std::make_shared<openvdb::FloatTree>(
            *refinement.refined(openvdb::MaskTree(values->tree(), false, true, openvdb::TopologyCopy())), 0.0f,
            openvdb::TopologyCopy()));
        const auto found = resampled(*values, *like);
        std::size_t visited = 0;
        for (auto voxel = found->cbeginValueOn(); voxel; ++voxel, ++visited) {
            Vec3d position;
            for (int axis = 0; axis < 3; ++axis)
                position[axis] = (voxel.getCoord()[axis] + 0.5) / factors[std::size_t(axis)] - 0.5;
            ASSERT_EQ(*voxel, valueAt(accessor, position)) << voxel.getCoord() << " of " << factors[0];
        }
        EXPECT_EQ(visited, values->activeVoxelCount() * std::uint64_t(refinement.voxels()));
        EXPECT_EQ(found->tree().getValue({-500, 0, 0}), 0);
        for (auto leaf = found->tree().cbeginLeaf(); leaf; ++leaf) {
            for (auto voxel = leaf->cbeginValueOff(); voxel; ++voxel)
                ASSERT_EQ(*voxel, 0) << voxel.getCoord();
        }
    }
}

TEST(Resampled, LeavesOutLeavesWithoutValuesAndExpandsTiles)
{
    const auto values = openvdb::FloatGrid::create(0);
    values->fill({Coord(-8), Coord(40)}, 3);
    const auto like = openvdb::FloatGrid::create(0);
    like->tree().addTile(1, Coord(8, 0, 0), 1, true);
    like->tree().setValue({1, 2, 3}, 1);
    using Leaf = openvdb::FloatTree::LeafNodeType;
    auto* const empty = new Leaf(openvdb::PartialCreate(), Coord(0, 16, 0), 0.0f, true);
    ASSERT_TRUE(empty->buffer().empty());
    like->tree().addLeaf(empty); // takes it over
    const auto found = resampled(*values, *like);
    EXPECT_EQ(found->activeVoxelCount(), 1u + 512);
    EXPECT_EQ(found->tree().getValue({1, 2, 3}), 3);
    EXPECT_EQ(found->tree().getValue({15, 7, 7}), 3);
}

} // namespace
} // namespace vdblic
