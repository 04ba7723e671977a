#include "vdblic/field/refinement.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/domain.h"
#include "vdblic/field/velocity_field.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <memory>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3d;
using openvdb::math::Transform;

TEST(Refinement, RefusesFactorsOutOfRange)
{
    EXPECT_NO_THROW((Refinement{{1, 16, 3}}.validate()));
    EXPECT_THROW((Refinement{{0, 1, 1}}.validate()), ParameterError);
    EXPECT_THROW((Refinement{{1, 17, 1}}.validate()), ParameterError);
}

TEST(Refinement, AVoxelOfTheVelocityIsFilledExactly)
{
    const Refinement refinement{{3, 2, 1}};
    EXPECT_EQ(refinement.coarse({{-1, -1, -1}}).at, Coord(-1, -1, -1));
    EXPECT_EQ(refinement.coarse({{-3, -2, 5}}).at, Coord(-1, -1, 5));
    EXPECT_EQ(refinement.coarse({{-4, 3, 0}}).at, Coord(-2, 1, 0));
    EXPECT_EQ(refinement.coarse({{5, 4, 0}}).at, Coord(1, 2, 0));

    auto velocity = std::make_shared<openvdb::MaskTree>();
    velocity->setValueOn({-9, 7, 8});
    velocity->setValueOn({0, 0, 0});
    velocity->fill({{16, -8, 0}, {23, -1, 7}}, true); // a tile or a full leaf
    const openvdb::MaskTree::Ptr texture = refinement.refined(*velocity);
    EXPECT_EQ(texture->activeVoxelCount(), velocity->activeVoxelCount() * 6);
    for (auto voxel = texture->cbeginValueOn(); voxel; ++voxel)
        ASSERT_TRUE(velocity->isValueOn(refinement.coarse({voxel.getCoord()}).at));
    EXPECT_TRUE(texture->isValueOn({-27, 14, 8}));
    EXPECT_TRUE(texture->isValueOn({-25, 15, 8}));
    EXPECT_FALSE(texture->isValueOn({-24, 15, 8}));
    velocity->voxelizeActiveTiles();
    EXPECT_TRUE(refinement.coarsened(*texture, *velocity)->hasSameTopology(*velocity));
}

TEST(Refinement, CoarsenedKeepsVoxelsWithAnyTexture)
{
    const Refinement refinement{{4, 4, 4}};
    openvdb::MaskTree velocity;
    velocity.fill({{-2, -2, -2}, {1, 1, 1}}, true);
    openvdb::MaskTree texture;
    texture.setValueOn({-1, -1, -1});
    texture.setValueOn({7, 0, 0});
    const auto kept = refinement.coarsened(texture, velocity);
    EXPECT_EQ(kept->activeVoxelCount(), 2u);
    EXPECT_TRUE(kept->isValueOn({-1, -1, -1}));
    EXPECT_TRUE(kept->isValueOn({1, 0, 0}));
}

TEST(Refinement, TheTransformPlacesTextureVoxelsInTheirVelocityVoxel)
{
    const Refinement refinement{{4, 2, 3}};
    const auto velocity = Transform::createLinearTransform(0.25);
    velocity->postRotate(0.3, openvdb::math::Z_AXIS);
    velocity->preScale(Vec3d(1, -2, 3)); // mirrored
    velocity->postTranslate(Vec3d(5, -7, 1));
    const auto texture = refinement.refined(*velocity);
    for (const Coord f : {Coord(0, 0, 0), Coord(-5, 7, 11), Coord(100, -3, 2)}) {
        Vec3d index;
        for (int axis = 0; axis < 3; ++axis)
            index[axis] = (f[axis] + 0.5) / refinement.factors[std::size_t(axis)] - 0.5;
        EXPECT_LT((texture->indexToWorld(f) - velocity->indexToWorld(index)).length(), 1e-12);
    }
    EXPECT_EQ(*Refinement{}.refined(*velocity), *velocity);
}

TEST(Refinement, IsFoundBetweenTransforms)
{
    const auto velocity = Transform::createLinearTransform(0.25);
    velocity->postRotate(0.3, openvdb::math::Z_AXIS);
    velocity->preScale(Vec3d(1, -2, 3)); // mirrored
    velocity->postTranslate(Vec3d(5, -7, 1));
    for (const Refinement refinement : {Refinement{}, Refinement{{3, 3, 3}}, Refinement{{4, 1, 16}}})
        EXPECT_EQ(Refinement::between(*velocity, *refinement.refined(*velocity)), refinement);

    const auto is = [&](const auto& change) {
        const auto texture = Refinement{{2, 2, 2}}.refined(*velocity);
        change(*texture);
        return Refinement::between(*velocity, *texture).has_value();
    };
    EXPECT_TRUE(is([](Transform&) {}));
    EXPECT_FALSE(is([](Transform& texture) { texture.preTranslate(Vec3d(0.01, 0, 0)); }));
    EXPECT_FALSE(is([](Transform& texture) { texture.preTranslate(Vec3d(0.5)); })); // corners on corners
    EXPECT_FALSE(is([](Transform& texture) { texture.preScale(1.25); }));
    EXPECT_FALSE(is([](Transform& texture) { texture.preScale(4); })); // coarser
    EXPECT_FALSE(is([](Transform& texture) { texture.preScale(2.0 / 17); }));
    EXPECT_FALSE(is([](Transform& texture) { texture.postRotate(0.01, openvdb::math::X_AXIS); }));
    EXPECT_FALSE(Refinement::between(*Transform::createLinearTransform(1e300), *velocity));
}

TEST(VelocityField, OfARefinedDomainIsSampledAtTheTexturesPositions)
{
    // Linear in space: v(p) = (p_y, 2 p_z, 1 − p_x) / 8 at velocity index p, in voxels of the velocity per step.
    const auto at = [](const Vec3d& p) { return Vec3d(p[1], 2 * p[2], 1 - p[0]) / 8; };
    openvdb::Vec3STree tree;
    for (auto voxel = openvdb::CoordBBox({-6, -6, -6}, {9, 9, 9}).begin(); voxel; ++voxel)
        tree.setValue(*voxel, openvdb::Vec3f(at((*voxel).asVec3d())));
    const Refinement refinement{{2, 4, 1}};
    const openvdb::MaskTree topology(tree, false, true, openvdb::TopologyCopy());
    VelocityField field;
    const Velocities<Space::kVelocity, Per::kStep> level{tree, {openvdb::Mat3d::identity()}};
    field.build({std::make_shared<Domain>(refinement.refined(topology)),
                 std::make_shared<Domain>(std::make_shared<openvdb::MaskTree>(topology)), refinement},
                level, level);
    for (const Vec3d& position : {Vec3d(0, 0, 0), Vec3d(-9.25, 13.5, 3.125), Vec3d(17, -20, -5.5)}) {
        Vec3d index;
        for (int axis = 0; axis < 3; ++axis)
            index[axis] = (position[axis] + 0.5) / refinement.factors[std::size_t(axis)] - 0.5;
        const Vec3d expected = at(index) * Vec3d(2, 4, 1); // texture voxels per step
        const Float4 single = field.sample(Float4{float(position[0]), float(position[1]), float(position[2]), 0}, 0.5f,
                                           Float4{9, 9, 9, 0});
        Vector8 eight{};
        eight.setLane(3, Float4{float(position[0]), float(position[1]), float(position[2]), 0});
        const Vector8 found = field.sample(Bricks::Window{}, eight, broadcast8(0.5f), Vector8{}, 8);
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_NEAR(single[axis], expected[axis], 1e-5) << axis;
            EXPECT_EQ(found.lane(3)[axis], single[axis]) << axis;
        }
    }
}

} // namespace
} // namespace vdblic
