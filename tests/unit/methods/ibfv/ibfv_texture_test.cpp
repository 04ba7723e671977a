#include "vdblic/methods/ibfv/ibfv_texture.h"

#include "methods/test_flow.h"
#include "vdblic/methods/ibfv/ibfv.h"
#include "vdblic/methods/ibfv/periodic_noise.h"
#include "vdblic/methods/registry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

constexpr double kAlpha = 0.3;
const openvdb::CoordBBox kIbfvBox({-5, 3, -9}, {34, 14, 6});

/// The last texture of so many steps.
LeafValues<float> ibfvOf(const std::vector<VelocityFrame>& frames, int substeps = 1)
{
    TextureParams params;
    params.method = &kIbfv;
    params.substeps = substeps;
    const auto texture = makeFlowTexture({params, {}, {.alpha = kAlpha}}, {NoiseField(7)});
    LeafValues<float> last;
    for (std::size_t k = 0; k + 1 < frames.size(); ++k)
        last = texture->advance(test::stepFrom(frames, k)).texture;
    return last;
}

/// The noise with weights α (1 − α)^i at places along the way back, and what the first texture was at its end.
double literal(const Coord& at, const Vec3f& step, int steps, int places)
{
    const NoiseField noise(7);
    const double share = 1 - std::pow(1 - kAlpha, 1.0 / places);
    const auto noiseAt = [&](double back, int moment) {
        const Vec3f there = Vec3f(at.asVec3s()) - step * float(back);
        return double(PeriodicNoise(noise, std::uint64_t(moment), 1).at(Float4{there[0], there[1], there[2], 0}));
    };
    double sum = 0, weight = share;
    for (int place = 0; place < steps * places; ++place, weight *= 1 - share)
        sum += weight * noiseAt(double(place) / places, steps - place / places);
    const double first = 0.5 + std::sqrt(kAlpha / (2 - kAlpha)) * (noiseAt(steps, 0) - 0.5);
    return sum + std::pow(1 - kAlpha, steps) * first;
}

void expectLiteral(const Vec3f& velocity, int places, const openvdb::CoordBBox& inside)
{
    constexpr int kSteps = 5;
    const auto frames = test::makeFrames(kIbfvBox, kSteps + 2, [&](const Coord&, int) { return velocity; });
    const LeafValues<float> texture = ibfvOf(frames);
    for (const Coord& at : inside)
        ASSERT_NEAR(texture.tree()->getValue(at), literal(at, velocity, kSteps, places), 2e-6) << at;
}

TEST(IbfvTexture, WeighsTheNoiseAlongAUniformFlow)
{
    expectLiteral(Vec3f(1, 0, 0), 1, {{1, 3, -9}, {34, 14, 6}});
    expectLiteral(Vec3f(2, 0, 0), 1, {{6, 3, -9}, {34, 14, 6}});
    expectLiteral(Vec3f(5, 0, 0), 3, {{21, 3, -9}, {34, 14, 6}}); // as three steps would
    expectLiteral(Vec3f(0, 0, -3), 2, {{-5, 3, -9}, {34, 14, -9}});
}

TEST(IbfvTexture, OfAFlowAtRestIsAMeanOfTheNoiseInEveryVoxel)
{
    expectLiteral(Vec3f(0), 1, kIbfvBox);
}

TEST(IbfvTexture, EnteringFluidBringsTheNoiseThatItWouldHaveMetOutside)
{
    // After many steps nothing is left of the first texture. What entered last had the noise outside, whose older part
    // is cut off.
    constexpr int kSteps = 24;
    const auto frames = test::makeFrames(kIbfvBox, kSteps + 2, [](const Coord&, int) { return Vec3f(2, 0, 0); });
    const LeafValues<float> texture = ibfvOf(frames);
    double error = 0;
    for (const Coord& at : openvdb::CoordBBox({-5, 3, -9}, {-4, 14, 6})) {
        error = std::max(error, std::abs(texture.tree()->getValue(at) - literal(at, Vec3f(2, 0, 0), kSteps, 1)));
    }
    EXPECT_LT(error, 0.09);
}

/// Places and velocities of the same flow in voxels of a texture that is three times as fine.
TEST(IbfvTexture, OfARefinedFlowIsThatOfAFinerOne)
{
    constexpr int kSteps = 4;
    const openvdb::CoordBBox box({0, 0, 0}, {15, 7, 7}), fine({0, 0, 0}, {47, 23, 23});
    const auto coarse = test::makeFrames(box, kSteps + 2, [](const Coord&, int) { return Vec3f(1, 0.5f, 0); });
    const auto finer = test::makeFrames(fine, kSteps + 2, [](const Coord&, int) { return Vec3f(3, 1.5f, 0); });
    const auto a = ibfvOf(test::refined(coarse, {{3, 3, 3}})), b = ibfvOf(finer);
    for (const Coord& at : fine)
        ASSERT_NEAR(a.tree()->getValue(at), b.tree()->getValue(at), 1e-5) << at;
}

} // namespace
} // namespace vdblic
