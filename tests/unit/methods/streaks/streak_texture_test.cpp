#include "vdblic/methods/streaks/streak_texture.h"

#include "methods/test_flow.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/methods/streaks/streaks.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <optional>
#include <vector>

namespace vdblic {
namespace {

StreakParams smallStreaks()
{
    StreakParams params;
    params.spacing = {2, 2, 2};
    params.tail = 2.0f;
    return params;
}

Refinement fourfold()
{
    Refinement refinement{{4, 4, 4}};
    refinement.isGiven = true;
    return refinement;
}

StreakTexture begun(const std::vector<VelocityFrame>& frames, const StreakParams& params = smallStreaks())
{
    StreakTexture texture({.method = &kStreaks}, params, fourfold(), 1);
    (void)texture.choose(*frames.front().domain.texture, 1);
    return texture;
}

bool areEqual(const openvdb::FloatTree& a, const openvdb::FloatTree& b)
{
    if (!a.hasSameTopology(b)) return false;
    for (auto value = a.cbeginValueOn(); value; ++value) {
        if (*value != b.getValue(value.getCoord())) return false;
    }
    return true;
}

/// Uniform flow along x, two voxels a frame.
std::vector<VelocityFrame> uniformFlow(int frames)
{
    return test::makeFrames({{0, 0, 0}, {47, 15, 15}}, frames,
                            [](const openvdb::Coord&, int) { return openvdb::Vec3f(2, 0, 0); });
}

TEST(StreakTexture, DoesNotDependOnTheNumberOfThreads)
{
    const std::vector<VelocityFrame> frames = test::unsteadyFlowWithHole(5);
    std::vector<openvdb::FloatTree::Ptr> one, many;
    {
        const tbb::global_control single(tbb::global_control::max_allowed_parallelism, 1);
        StreakTexture texture = begun(frames);
        for (std::size_t k = 0; k < 4; ++k)
            one.push_back(texture.advance(test::stepFrom(frames, k)).texture.tree());
    }
    StreakTexture texture = begun(frames);
    for (std::size_t k = 0; k < 4; ++k) {
        const openvdb::FloatTree::Ptr tree = texture.advance(test::stepFrom(frames, k)).texture.tree();
        EXPECT_GT(tree->activeVoxelCount(), 1000u);
        EXPECT_TRUE(areEqual(*one[k], *tree)) << k;
    }
}

TEST(StreakTexture, GoesOnFromASavedState)
{
    const std::vector<VelocityFrame> frames = test::unsteadyFlowWithHole(6);
    StreakTexture whole = begun(frames);
    for (std::size_t k = 0; k < 3; ++k)
        (void)whole.advance(test::stepFrom(frames, k));
    StreakTexture other({.method = &kStreaks}, StreakParams{}, Refinement{}, 1);
    std::optional<VdbFile> file = VdbFile{whole.save(0).grids, {}, {}};
    other.restore(3, 1, frames[3].domain.texture, [&] { return std::exchange(file, std::nullopt); });
    for (std::size_t k = 3; k < 5; ++k) {
        const TextureFrame a = whole.advance(test::stepFrom(frames, k)), b = other.advance(test::stepFrom(frames, k));
        EXPECT_TRUE(areEqual(*a.texture.tree(), *b.texture.tree())) << k;
        EXPECT_EQ(b.refinement, fourfold());
    }
}

TEST(StreakTexture, MovesWithTheFlow)
{
    // Two velocity voxels a frame are eight of the texture.
    const std::vector<VelocityFrame> frames = uniformFlow(4);
    StreakTexture texture = begun(frames);
    const openvdb::FloatTree::Ptr before = texture.advance(test::stepFrom(frames, 0)).texture.tree(),
                                  after = texture.advance(test::stepFrom(frames, 1)).texture.tree();
    std::size_t same = 0, voxels = 0;
    for (auto value = before->cbeginValueOn(); value; ++value) {
        const openvdb::Coord moved = value.getCoord().offsetBy(8, 0, 0);
        if (moved[0] >= 4 * 48) continue;
        ++voxels;
        // Positions are rounded: values differ by a few steps, or are just too dark to be drawn.
        same += std::abs(after->getValue(moved) - *value) < 0.048f;
    }
    EXPECT_GT(voxels, 10000u);
    // Others lie where a streak was released meanwhile, or ahead of a head, where a tube ends steeply.
    EXPECT_GT(double(same), 0.9995 * double(voxels));
}

TEST(StreakTexture, SlidesInOverARim)
{
    // In uniform flow a streak in full brightness reaches the inflow: none waits behind the rim for its time to fade
    // in.
    const std::vector<VelocityFrame> frames = uniformFlow(8);
    StreakTexture texture = begun(frames);
    openvdb::FloatTree::Ptr last;
    for (std::size_t k = 0; k < 7; ++k)
        last = texture.advance(test::stepFrom(frames, k)).texture.tree();
    const auto brightest = [&](int from, int to) {
        float most = 0;
        for (auto value = last->cbeginValueOn(); value; ++value) {
            if (value.getCoord()[0] >= from && value.getCoord()[0] < to) most = std::max(most, *value);
        }
        return most;
    };
    EXPECT_GT(brightest(0, 16), 0.75f);
    EXPECT_GT(brightest(96, 112), 0.75f);
}

TEST(StreakTexture, FillsTheDomainEvenlyAndSteadily)
{
    const std::vector<VelocityFrame> frames = uniformFlow(12);
    StreakTexture texture = begun(frames);
    std::vector<double> live;
    for (std::size_t k = 0; k < 11; ++k) {
        const TextureFrame step = texture.advance(test::stepFrom(frames, k));
        live.push_back(double(step.stats.particles));
        EXPECT_EQ(step.stats.blocked, 0u); // nothing comes nearer in uniform flow
    }
    const double cells = 48 * 16 * 16 / 8.0;
    for (std::size_t k = 6; k < live.size(); ++k) {
        EXPECT_NEAR(live[k] / live[5], 1, 0.03) << k;
        EXPECT_GT(live[k], 0.6 * cells);
    }
}

TEST(StreakTexture, IsEmptyWhereThereIsNoVoxel)
{
    std::vector<VelocityFrame> frames = test::makeFrames(
        {{0, 0, 0}, {15, 15, 15}}, 4, [](const openvdb::Coord&, int frame) -> std::optional<openvdb::Vec3f> {
            return frame == 1 ? std::nullopt : std::optional(openvdb::Vec3f(1, 0, 0));
        });
    StreakTexture texture = begun(frames);
    EXPECT_GT(texture.advance(test::stepFrom(frames, 0)).texture.tree()->activeVoxelCount(), 0u);
    EXPECT_EQ(texture.advance(test::stepFrom(frames, 1)).texture.tree()->activeVoxelCount(), 0u);
    EXPECT_GT(texture.advance({frames[2], frames[3]}).texture.tree()->activeVoxelCount(), 0u);
}

} // namespace
} // namespace vdblic
