#include "vdblic/volume/coarse_scalar.h"

#include "vdblic/field/resample.h"
#include "vdblic/volume/texture_volume.h"
#include "volume/sample_place.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>

namespace vdblic {
namespace {

using openvdb::Coord;

constexpr int kFiner = 4; // even: no texture voxel lies on a coarse one, so none depends on rounding

/// A scalar on 6³ voxels with a hole, and a texture that refines it fourfold: a bar of one voxel's width.
struct SparseScene {
    openvdb::FloatGrid::Ptr scalar = openvdb::FloatGrid::create(), texture = openvdb::FloatGrid::create();

    SparseScene()
    {
        for (auto voxel = openvdb::CoordBBox({0, 0, 0}, {5, 5, 5}).begin(); voxel; ++voxel) {
            const Coord& c = *voxel;
            if (c != Coord(2, 2, 3)) scalar->tree().setValue(c, float(c[0]) + 0.1f * float(c[1] * c[1]) - float(c[2]));
        }
        scalar->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
        for (int x = 2; x < 16; ++x)
            texture->tree().setValue({x, 5, 9}, 0.5f);
        texture->setTransform(Refinement{{kFiner, kFiner, kFiner}}.refined(scalar->transform()));
    }

    [[nodiscard]] TextureVolume volume() const { return {*texture, *scalar, glm::dvec3(1), {.isSparse = true}}; }
};

TEST(SparseTexture, AScalarOnCoarserVoxelsIsInterpolatedAsResampled)
{
    const SparseScene scene;
    const TextureVolume volume = scene.volume();
    ASSERT_TRUE(volume.drivers().isCoarse());
    // resampled() has values at active voxels of the texture's: here at all of them.
    const auto all = openvdb::FloatGrid::create();
    all->tree().fill({{-1, -1, -1}, {24, 24, 24}}, 1.0f);
    all->tree().voxelizeActiveTiles();
    all->setTransform(scene.texture->transform().copy());
    const auto expected = resampled(*scene.scalar, *all);
    for (int x = 2; x < 16; ++x) {
        for (int y = 0; y < 8; ++y) {
            for (int z = 8; z < 16; ++z) {
                const Coord hole(2, 2, 3), c(x, y, z);
                bool isByHole = true; // a corner of the cell is the hole, which takes its neighbours' mean
                for (int axis = 0; axis < 3; ++axis) {
                    const double at = (c[axis] + 0.5) / kFiner - 0.5;
                    isByHole = isByHole && std::abs(at - hole[axis]) < 1;
                }
                const float value = driverAt(volume, c.asVec3d());
                EXPECT_NEAR(value, expected->tree().getValue(c), isByHole ? 0.3f : 1e-5f) << c;
            }
        }
    }
}

TEST(SparseTexture, AScalarOnOtherVoxelsIsNotCoarse)
{
    const SparseScene scene;
    EXPECT_FALSE(CoarseScalar::of(*scene.texture, *scene.texture));
    scene.scalar->setTransform(openvdb::math::Transform::createLinearTransform(0.51));
    EXPECT_FALSE(CoarseScalar::of(*scene.scalar, *scene.texture));
}

TEST(SparseTexture, InactiveVoxelsAreEmpty)
{
    const SparseScene scene;
    const TextureVolume volume = scene.volume();
    EXPECT_EQ(textureAt(volume, {6, 5, 9}), 0.5f);
    // A dense texture would continue its values there.
    EXPECT_EQ(textureAt(volume, {6, 4, 9}), 0);
    EXPECT_EQ(textureAt(volume, {6, 4, 10}), 0);
    // The bar is lit as a bar: values fall to both sides of it.
    EXPECT_NEAR(gradientAt(volume, {6, 4, 9}, 1), 0.25f, 1e-5f);
    EXPECT_NEAR(gradientAt(volume, {6, 6, 9}, 1), -0.25f, 1e-5f);
    EXPECT_NEAR(gradientAt(volume, {6, 4.5, 9}, 1), 0.125f, 1e-5f);
    EXPECT_EQ(gradientAt(volume, {6, 5, 9}, 1), 0);
}

TEST(SparseTexture, EmptyVoxelsHaveTheScalar)
{
    const SparseScene scene;
    const TextureVolume volume = scene.volume();
    const float there = driverAt(volume, {6, 5, 9});
    EXPECT_NEAR(driverAt(volume, {7, 5, 9}) - there, 1.0f / kFiner, 1e-4f); // the scalar rises by 1 a voxel along x
    EXPECT_NEAR(driverAt(volume, {6.5, 5, 9}) - there, 0.5f / kFiner, 1e-4f);
    EXPECT_NEAR(there - driverAt(volume, {6, 4, 9}), 0.1f / kFiner, 1e-4f); // from y = 0 to 1
}

} // namespace
} // namespace vdblic
