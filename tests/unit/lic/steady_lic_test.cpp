#include "vdblic/lic/steady_lic.h"

#include "lic/test_flow.h"
#include "vdblic/core/errors.h"
#include "vdblic/lic/lic_kernel.h"
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

LeafValues<float> licOf(const std::vector<FlowFrame>& frames, int lifeSpan, LicKernel kernel)
{
    return steadyLic(frames[0], openvdb::Mat3d::identity(), lifeSpan, kernel, {}, NoiseField(7));
}

double noiseAt(const Coord& at)
{
    return noiseValue(at[0], at[1], at[2], 7) / double(kNoiseMax);
}

TEST(SteadyLic, WithABoxIsTheMeanOfTheNoiseAlongTheStreamline)
{
    // Two voxels a step over four steps: four voxels each way, eight samples of half a voxel.
    const auto frames = test::makeFrames({{0, 0, 0}, {31, 3, 3}}, 1, [](auto&, int) { return Vec3f(2, 0, 0); });
    const auto texture = licOf(frames, 4, LicKernel::kBox);
    for (const Coord& at : openvdb::CoordBBox({8, 0, 0}, {22, 3, 3})) {
        double sum = 0;
        for (int voxel = -4; voxel <= 4; ++voxel) // the ends count half
            sum += noiseAt(at.offsetBy(voxel, 0, 0)) * (std::abs(voxel) == 4 ? 0.5 : 1);
        // The kernel's least speed makes the path a little longer than four voxels: a ninth sample may shift weights.
        EXPECT_NEAR(texture.tree()->getValue(at), sum / 8, 0.06);
    }
}

TEST(SteadyLic, WithHannWeighsTheMiddleMost)
{
    const auto frames = test::makeFrames({{0, 0, 0}, {31, 15, 15}}, 1, [](auto&, int) { return Vec3f(2, 0, 0); });
    const auto correlationWithNoise = [&](LicKernel kernel) {
        const auto texture = licOf(frames, 4, kernel);
        double ab = 0, aa = 0, bb = 0;
        for (const Coord& at : openvdb::CoordBBox({8, 0, 0}, {22, 15, 15})) {
            const double a = texture.tree()->getValue(at) - 0.5, b = noiseAt(at) - 0.5;
            ab += a * b;
            aa += a * a;
            bb += b * b;
        }
        return ab / std::sqrt(aa * bb);
    };
    // Of independent noise the correlation is the middle's weight over the root of the sum of squared weights.
    const double box = correlationWithNoise(LicKernel::kBox), hann = correlationWithNoise(LicKernel::kHann);
    EXPECT_NEAR(box, 1 / std::sqrt(7.5), 0.05);
    double squares = 1;
    for (int voxel = 1; voxel <= 4; ++voxel)
        squares += 2 * std::pow(0.5 + 0.5 * std::cos(std::numbers::pi * voxel / 4), 2);
    EXPECT_NEAR(hann, 1 / std::sqrt(squares), 0.05);
}

TEST(SteadyLic, IsTheSameBothWaysAndAtRestTheNoise)
{
    const auto forth = test::makeFrames({{0, 0, 0}, {15, 15, 15}}, 1, [](auto&, int) { return Vec3f(1, 2, 0); });
    const auto back = test::makeFrames({{0, 0, 0}, {15, 15, 15}}, 1, [](auto&, int) { return Vec3f(-1, -2, 0); });
    const auto a = licOf(forth, 4, LicKernel::kHann), b = licOf(back, 4, LicKernel::kHann);
    const auto still =
        licOf(test::makeFrames({{0, 0, 0}, {15, 15, 15}}, 1, [](auto&, int) { return Vec3f(0); }), 4, LicKernel::kHann);
    for (auto value = a.tree()->cbeginValueOn(); value; ++value) {
        EXPECT_NEAR(*value, b.tree()->getValue(value.getCoord()), 1e-6);
        EXPECT_NEAR(still.tree()->getValue(value.getCoord()), noiseAt(value.getCoord()), 1e-6);
    }
}

TEST(SteadyLic, KernelsHaveNames)
{
    EXPECT_EQ(parseLicKernel("box"), LicKernel::kBox);
    EXPECT_EQ(toString(parseLicKernel("hann")), "hann");
    EXPECT_THROW((void)parseLicKernel("gauss"), ParameterError);
}

} // namespace
} // namespace vdblic
