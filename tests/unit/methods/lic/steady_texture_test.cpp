#include "vdblic/methods/lic/steady_texture.h"

#include "methods/test_flow.h"
#include "vdblic/noise/noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

LeafValues<float> licOf(const std::vector<VelocityFrame>& frames, int lifeSpan)
{
    return SteadyTexture({.lifeSpan = lifeSpan}, NoiseField(7)).advance({frames[0], frames[0]}).texture;
}

double noiseAt(const Coord& at)
{
    return noiseValue(at[0], at[1], at[2], 7) / double(kNoiseMax);
}

/// A Hann window over four voxels to each side.
double weightAt(int voxel)
{
    return 0.5 + 0.5 * std::cos(std::numbers::pi * voxel / 4);
}

TEST(SteadyTexture, IsTheWeightedMeanOfTheNoiseAlongTheStreamline)
{
    // Two voxels a step over four steps: four voxels each way, in pieces of half a voxel.
    const auto frames = test::makeFrames({{0, 0, 0}, {31, 3, 3}}, 1, [](auto&, int) { return Vec3f(2, 0, 0); });
    const auto texture = licOf(frames, 4);
    for (const Coord& at : openvdb::CoordBBox({8, 0, 0}, {22, 3, 3})) {
        double sum = 0, weights = 0;
        for (int voxel = -4; voxel <= 4; ++voxel) {
            sum += weightAt(voxel) * noiseAt(at.offsetBy(voxel, 0, 0));
            weights += weightAt(voxel);
        }
        // The kernel's least speed makes the path a little longer than four voxels: weights may shift by a piece.
        EXPECT_NEAR(texture.tree()->getValue(at), sum / weights, 0.06);
    }
}

TEST(SteadyTexture, WeighsTheMiddleMost)
{
    const auto frames = test::makeFrames({{0, 0, 0}, {31, 15, 15}}, 1, [](auto&, int) { return Vec3f(2, 0, 0); });
    const auto texture = licOf(frames, 4);
    double ab = 0, aa = 0, bb = 0;
    for (const Coord& at : openvdb::CoordBBox({8, 0, 0}, {22, 15, 15})) {
        const double a = texture.tree()->getValue(at) - 0.5, b = noiseAt(at) - 0.5;
        ab += a * b;
        aa += a * a;
        bb += b * b;
    }
    // Of independent noise the correlation is the middle's weight over the root of the sum of squared weights.
    double squares = 1;
    for (int voxel = 1; voxel <= 4; ++voxel)
        squares += 2 * std::pow(weightAt(voxel), 2);
    EXPECT_NEAR(ab / std::sqrt(aa * bb), 1 / std::sqrt(squares), 0.05);
}

TEST(SteadyTexture, IsTheSameBothWaysAndAtRestTheNoise)
{
    const auto forth = test::makeFrames({{0, 0, 0}, {15, 15, 15}}, 1, [](auto&, int) { return Vec3f(1, 2, 0); });
    const auto back = test::makeFrames({{0, 0, 0}, {15, 15, 15}}, 1, [](auto&, int) { return Vec3f(-1, -2, 0); });
    const auto a = licOf(forth, 4), b = licOf(back, 4);
    const auto still = licOf(test::makeFrames({{0, 0, 0}, {15, 15, 15}}, 1, [](auto&, int) { return Vec3f(0); }), 4);
    for (auto value = a.tree()->cbeginValueOn(); value; ++value) {
        EXPECT_NEAR(*value, b.tree()->getValue(value.getCoord()), 1e-6);
        EXPECT_NEAR(still.tree()->getValue(value.getCoord()), noiseAt(value.getCoord()), 1e-6);
    }
}

} // namespace
} // namespace vdblic
