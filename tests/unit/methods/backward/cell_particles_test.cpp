#include "vdblic/methods/backward/cell_particles.h"

#include "methods/test_flow.h"
#include "vdblic/noise/noise_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

const openvdb::CoordBBox kCellBox({-5, 3, -9}, {34, 14, 6});

/// The particles after so many steps.
CellParticles movedBy(const test::FlowFunction& flow, int steps)
{
    const auto frames = test::makeFrames(kCellBox, steps + 1, flow);
    const NoiseField noise(7);
    CellParticles particles = CellParticles::centred(*frames[0].domain.texture, noise);
    const TextureParams params;
    StageClock clock;
    for (std::size_t k = 0; k < std::size_t(steps); ++k)
        particles = particles.moved(test::stepFrom(frames, k), noise, k, params.pathline, clock);
    return particles;
}

/// Values are those of the noise so many voxels upstream, in a box.
void expectMoved(const CellParticles& particles, const Coord& by, const openvdb::CoordBBox& inside)
{
    const NoiseField noise(7);
    for (const Coord& at : inside)
        ASSERT_EQ(particles.values.tree()->getValue(at), float(noise.at(at - by))) << at;
}

TEST(CellParticles, AreMovedByWholeVoxelsWithoutBlur)
{
    expectMoved(movedBy([](const Coord&, int) { return Vec3f(2, 0, -1); }, 4), {8, 0, -4}, {{3, 3, -9}, {34, 14, 2}});
    expectMoved(movedBy([](const Coord&, int) { return Vec3f(0); }, 4), {0, 0, 0}, kCellBox);
}

TEST(CellParticles, AddUpPartsOfAVoxel)
{
    expectMoved(movedBy([](const Coord&, int) { return Vec3f(0.3f, 0, 0); }, 10), {3, 0, 0}, {{0, 3, -9}, {34, 14, 6}});
    expectMoved(movedBy([](const Coord&, int) { return Vec3f(0, -1.7f, 0); }, 4), {0, -7, 0},
                {{-5, 3, -9}, {34, 6, 6}});
}

TEST(CellParticles, KeepTheNoisesHistogram)
{
    // In a flow that enters through a face, and in one that is stretched along x and pressed together along y.
    const auto uniform = [](const Coord&, int) { return Vec3f(3, 0, 0); };
    const auto strained = [](const Coord& at, int) {
        return Vec3f(0.1f * float(at[0] - 15), -0.1f * float(at[1] - 8), 0);
    };
    for (const test::FlowFunction& flow : {test::FlowFunction(uniform), test::FlowFunction(strained)}) {
        const CellParticles particles = movedBy(flow, 20);
        double sum = 0, squares = 0, count = 0;
        for (auto value = particles.values.tree()->cbeginValueOn(); value; ++value, ++count) {
            const double share = *value / CellParticles::kWhite;
            ASSERT_TRUE(share >= 0 && share <= 1);
            sum += share;
            squares += share * share;
        }
        EXPECT_EQ(count, double(kCellBox.volume()));
        EXPECT_NEAR(sum / count, 0.5, 0.02);
        EXPECT_NEAR(std::sqrt(squares / count - std::pow(sum / count, 2)), std::sqrt(1.0 / 12), 0.015);
    }
}

TEST(CellParticles, AreRenewedWhereFluidIsStretched)
{
    const auto shareOfPairs = [](float strain) {
        const CellParticles particles =
            movedBy([&](const Coord& at, int) { return Vec3f(strain * float(at[0] - 15), 0, 0); }, 30);
        double pairs = 0, equal = 0;
        for (const Coord& at : openvdb::CoordBBox(kCellBox.min(), kCellBox.max().offsetBy(-1, 0, 0))) {
            ++pairs;
            equal += particles.values.tree()->getValue(at) == particles.values.tree()->getValue(at.offsetBy(1, 0, 0));
        }
        return equal / pairs;
    };
    EXPECT_LT(shareOfPairs(0), 0.001);
    EXPECT_GT(shareOfPairs(0.1f), 0.05); // some values are repeated
    EXPECT_LT(shareOfPairs(0.1f), 0.8);  // without new noise nine tenths would be
}

TEST(CellParticles, EnteringFluidBringsNewNoiseInEveryStep)
{
    const auto flow = [](const Coord&, int) { return Vec3f(1, 0, 0); };
    const CellParticles before = movedBy(flow, 6), after = movedBy(flow, 7);
    int equal = 0;
    for (const Coord& at : openvdb::CoordBBox({-5, 3, -9}, {-5, 14, 6}))
        equal += before.values.tree()->getValue(at) == after.values.tree()->getValue(at);
    EXPECT_LE(equal, 1);
}

TEST(CellParticles, FromFarAwayLieInTheirVoxels)
{
    for (const float speed : {1e6f, 1e12f, 1e30f}) {
        const CellParticles particles = movedBy([&](const Coord&, int) { return Vec3f(speed, -speed, 0); }, 2);
        for (const Coord& at : kCellBox) {
            const auto code = std::int32_t(particles.offsets.tree()->getValue(at)); // three numbers of 1 to 255
            ASSERT_TRUE((code & 0xff) && (code & 0xff00) && (code & 0xff0000) && code > 0 && code < 1 << 24)
                << at << speed;
            ASSERT_LE(particles.values.tree()->getValue(at), CellParticles::kWhite);
        }
    }
}

} // namespace
} // namespace vdblic
