#include "vdblic/volume/coarse_scalar.h"

#include "vdblic/field/resample.h"
#include "vdblic/volume/texture_records.h"
#include "vdblic/volume/texture_volume.h"

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

std::size_t recordAt(const TextureVolume& volume, const Coord& c)
{
    const int leaf = volume.domain().findLeaf(Int4{c[0], c[1], c[2]});
    return std::size_t(leaf) * kPaddedSize +
           std::size_t(paddedIndex(LeafVoxel::local(c[0]), LeafVoxel::local(c[1]), LeafVoxel::local(c[2])));
}

float gradientAlong(const TextureVolume& volume, const Coord& c, int axis)
{
    return __builtin_bit_cast(float, unsigned(volume.gradients()[recordAt(volume, c)].values[axis]) << 16);
}

TEST(SparseTexture, AScalarOnCoarserVoxelsIsInterpolatedAsResampled)
{
    const SparseScene scene;
    const auto coarse = CoarseScalar::of(*scene.scalar, *scene.texture);
    ASSERT_TRUE(coarse);
    // resampled() has values at active voxels of the texture's: here at all of them.
    const auto all = openvdb::FloatGrid::create();
    all->tree().fill({{-1, -1, -1}, {24, 24, 24}}, 1.0f);
    all->tree().voxelizeActiveTiles();
    all->setTransform(scene.texture->transform().copy());
    const auto expected = resampled(*scene.scalar, *all);
    constexpr int kDim = 12;
    float values[kDim * kDim * kDim];
    const Coord first(3, 2, 6);
    coarse->sample(first, kDim, values);
    for (int x = 0; x < kDim; ++x) {
        for (int y = 0; y < kDim; ++y) {
            for (int z = 0; z < kDim; ++z) {
                const float value = values[(x * kDim + y) * kDim + z];
                EXPECT_NEAR(value, expected->tree().getValue(first.offsetBy(x, y, z)), 1e-5f)
                    << x << ' ' << y << ' ' << z;
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
    EXPECT_EQ(volume.values()[recordAt(volume, {6, 5, 9})].texture, 0.5f);
    // A dense texture would continue its values there.
    EXPECT_EQ(volume.values()[recordAt(volume, {6, 4, 9})].texture, 0);
    EXPECT_EQ(volume.values()[recordAt(volume, {6, 4, 10})].texture, 0);
    // The bar is lit as a bar: values fall to both sides of it.
    EXPECT_NEAR(gradientAlong(volume, {6, 4, 9}, 1), 0.25f, 1e-3f);
    EXPECT_NEAR(gradientAlong(volume, {6, 6, 9}, 1), -0.25f, 1e-3f);
    EXPECT_EQ(gradientAlong(volume, {6, 5, 9}, 1), 0);
}

TEST(SparseTexture, EmptyVoxelsHaveTheScalar)
{
    const SparseScene scene;
    const TextureVolume volume = scene.volume();
    const float there = volume.values()[recordAt(volume, {6, 5, 9})].driver;
    const float beside = volume.values()[recordAt(volume, {7, 5, 9})].driver;
    EXPECT_NEAR(beside - there, 1.0f / kFiner, 1e-4f); // the scalar rises by 1 a voxel along x
    EXPECT_NEAR(there - volume.values()[recordAt(volume, {6, 4, 9})].driver, 0.1f / kFiner, 1e-4f); // from y = 0 to 1
}

} // namespace
} // namespace vdblic
