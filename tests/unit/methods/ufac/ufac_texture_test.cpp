#include "vdblic/methods/ufac/ufac_texture.h"

#include "methods/test_flow.h"
#include "vdblic/lic/streamline_convolution.h"
#include "vdblic/methods/backward/cell_particles.h"
#include "vdblic/methods/lic/steady_texture.h"
#include "vdblic/methods/registry.h"
#include "vdblic/methods/ufac/ufac.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

const openvdb::CoordBBox kUfacBox({-5, 3, -9}, {58, 14, 6});

std::unique_ptr<FlowTexture> makeUfac()
{
    TextureParams params;
    params.method = &kUfac;
    return makeFlowTexture({params, {}, {}}, {NoiseField(7)});
}

void expectEqual(const LeafValues<float>& a, const LeafValues<float>& b, const openvdb::CoordBBox& inside)
{
    for (const Coord& at : inside)
        ASSERT_EQ(a.tree()->getValue(at), b.tree()->getValue(at)) << at;
}

std::optional<Vec3f> turning(const Coord& at, int)
{
    return Vec3f(1.5f + std::sin(0.2f * float(at[1])), std::cos(0.3f * float(at[0])), 0.4f);
}

TEST(UfacTexture, OfASteadyFlowIsSteadyLic)
{
    const auto frames = test::makeFrames(kUfacBox, 5, turning);
    const auto texture = makeUfac();
    const TextureFrame made = texture->advance(test::stepFrom(frames, 0));
    expectEqual(made.texture, SteadyTexture({}, NoiseField(7)).advance(test::stepFrom(frames, 0)).texture, kUfacBox);

    // Later on it is that of the noise as it has moved.
    (void)texture->advance(test::stepFrom(frames, 1));
    const auto moved = openvdb::gridPtrCast<openvdb::FloatGrid>(test::memoryOf(*texture).save(0).grids.front());
    ASSERT_EQ(moved->getName(), "noise");
    const Domain& domain = *frames[2].domain.texture;
    const FlowStep step = test::stepFrom(frames, 2);
    const TextureParams params;
    StageClock clock;
    const StreamlineConvolution convolution{step, params.kernelHalf(), params.pathline};
    const LeafValues<float> input(domain, moved->treePtr());
    expectEqual(texture->advance(step).texture, convolution(input, CellParticles::kWhite, clock), kUfacBox);
}

/// A velocity that changes by a in a step is followed for √(2 / a) steps: of 2 voxels, for one.
TEST(UfacTexture, HasShorterLinesWhereTheFlowIsUnsteady)
{
    const auto frames =
        test::makeFrames(kUfacBox, 2, [](const Coord&, int frame) { return Vec3f(8, 2 * float(frame), 0); });
    const LeafValues<float> texture = makeUfac()->advance(test::stepFrom(frames, 0)).texture;
    const FlowStep step = test::stepFrom(frames, 0);
    const TextureParams halved{.lifeSpan = 2};
    const LeafValues<float> shorter = SteadyTexture(halved, NoiseField(7)).advance(step).texture;
    const LeafValues<float> whole = SteadyTexture({}, NoiseField(7)).advance(step).texture;
    const openvdb::CoordBBox inside({12, 3, -9}, {41, 14, 6}); // a whole kernel away from the ends
    expectEqual(texture, shorter, inside);
    int equal = 0;
    for (const Coord& at : inside)
        equal += texture.tree()->getValue(at) == whole.tree()->getValue(at);
    EXPECT_LT(equal, 10);
}

TEST(UfacTexture, OfAFlowAtRestIsTheNoise)
{
    const auto frames = test::makeFrames(kUfacBox, 4, [](const Coord&, int) { return Vec3f(0); });
    const auto ufac = makeUfac();
    LeafValues<float> texture;
    for (std::size_t k = 0; k < 3; ++k)
        texture = ufac->advance(test::stepFrom(frames, k)).texture;
    for (const Coord& at : kUfacBox)
        ASSERT_NEAR(texture.tree()->getValue(at), float(NoiseField(7).at(at)) / CellParticles::kWhite, 1e-6) << at;
}

} // namespace
} // namespace vdblic
