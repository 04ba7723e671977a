#include "vdblic/methods/lea/lea_texture.h"

#include "methods/test_flow.h"
#include "vdblic/methods/backward/cell_particles.h"
#include "vdblic/methods/lea/lea.h"
#include "vdblic/methods/registry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

constexpr double kLeaAlpha = 0.3;
const openvdb::CoordBBox kLeaBox({-5, 3, -9}, {34, 14, 6});

double leaNoise(const Coord& at)
{
    return NoiseField(7).at(at) / double(CellParticles::kWhite);
}

std::unique_ptr<FlowTexture> leaAfter(const std::vector<VelocityFrame>& frames, LeafValues<float>& last)
{
    TextureParams params;
    params.method = &kLea;
    auto texture = makeFlowTexture({params, {}, {.alpha = kLeaAlpha}}, {NoiseField(7)});
    for (std::size_t k = 0; k + 1 < frames.size(); ++k)
        last = texture->advance(test::stepFrom(frames, k)).texture;
    return texture;
}

TEST(LeaTexture, BlendsTheNoiseThatPassedAVoxel)
{
    constexpr int kSteps = 5;
    const Coord step(2, 0, 0);
    LeafValues<float> last;
    const auto texture =
        leaAfter(test::makeFrames(kLeaBox, kSteps + 1, [&](const Coord&, int) { return Vec3f(step.asVec3s()); }), last);
    const openvdb::GridPtrVec grids = test::memoryOf(*texture).save(0).grids;
    const auto blended = openvdb::gridPtrCast<openvdb::FloatGrid>(grids.back());
    ASSERT_EQ(blended->getName(), "texture");
    for (const Coord& at : openvdb::CoordBBox({6, 3, -9}, {34, 14, 6})) {
        double expected = 0.5 + std::sqrt(kLeaAlpha / (2 - kLeaAlpha)) * (leaNoise(at) - 0.5);
        for (int k = 1; k <= kSteps; ++k)
            expected += kLeaAlpha * (leaNoise({at[0] - k * step[0], at[1], at[2]}) - expected);
        ASSERT_NEAR(blended->tree().getValue(at), expected, 1e-6) << at;
    }
}

TEST(LeaTexture, OfAFlowAtRestBecomesTheNoise)
{
    LeafValues<float> texture;
    (void)leaAfter(test::makeFrames(kLeaBox, 42, [](const Coord&, int) { return Vec3f(0); }), texture);
    for (const Coord& at : kLeaBox)
        ASSERT_NEAR(texture.tree()->getValue(at), leaNoise(at), 1e-5) << at;
}

/// Along the flow neighbours are alike, across it they are not.
TEST(LeaTexture, HasLinesAlongTheFlow)
{
    LeafValues<float> texture;
    (void)leaAfter(test::makeFrames(kLeaBox, 20, [](const Coord&, int) { return Vec3f(2, 0, 0); }), texture);
    const auto correlation = [&](const Coord& to) {
        double both = 0, squares = 0;
        for (const Coord& at : openvdb::CoordBBox({6, 4, -8}, {30, 13, 5})) {
            const double here = texture.tree()->getValue(at) - 0.5, there = texture.tree()->getValue(at + to) - 0.5;
            both += here * there;
            squares += here * here;
        }
        return both / squares;
    };
    EXPECT_GT(correlation({1, 0, 0}), 0.75);
    EXPECT_GT(correlation({2, 0, 0}), 0.6);
    EXPECT_LT(std::abs(correlation({0, 1, 0})), 0.2);
}

} // namespace
} // namespace vdblic
