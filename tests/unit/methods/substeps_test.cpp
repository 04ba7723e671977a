#include "methods/test_flow.h"
#include "temporary_folder.h"
#include "vdblic/core/reporter.h"
#include "vdblic/flow/frame_between.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/methods/auflic/release_turn.h"
#include "vdblic/methods/flow_texture.h"
#include "vdblic/methods/lic/lic.h"
#include "vdblic/methods/registry.h"
#include "vdblic/run/advect.h"
#include "vdblic/run/advect_plan.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

/// A flow that is linear in time, whose numbers a float holds exactly; one voxel is missing in some frames.
std::optional<Vec3f> linearInTime(const Coord& at, double frame)
{
    const double x = at[0], y = at[1], z = at[2];
    return Vec3f(float(1 + y / 16 + 0.5 * frame), float(x / 32 - z / 16 * frame), float(0.25 * frame - y / 8));
}

struct Method {
    const char* name;
    const TextureMethod* method;
};

class Substeps : public testing::TestWithParam<Method> {};

/// Textures of frames 0, 1 and 2 with four substeps equal those of a sequence that holds the frames between.
TEST_P(Substeps, EqualTheFramesBetween)
{
    constexpr int kSubsteps = 4, kFrames = 3;
    const openvdb::CoordBBox box({-4, 2, -9}, {19, 21, 6});
    const auto coarse =
        test::makeFrames(box, kFrames, [&](const Coord& at, int frame) { return linearInTime(at, frame); });
    const auto dense = test::makeFrames(box, (kFrames - 1) * kSubsteps + 1, [&](const Coord& at, int frame) {
        return linearInTime(at, double(frame) / kSubsteps);
    });

    const TemporaryFolder folder;
    for (int frame = 0; frame < kFrames; ++frame) {
        const auto grid = coarse[std::size_t(frame)].values->deepCopy();
        grid->setName("velocity");
        writeVdb(folder / fmt::format("v.{}.vdb", frame), {grid}, {});
    }
    AdvectParams params;
    params.flow.input.pattern = (folder / "v.%d.vdb").string();
    params.output = (folder / "t.%d.vdb").string();
    params.flow.frameSpacing = 1;
    params.format.precision = GridPrecision::kFloat;
    params.finish = 0;
    params.texture.method = GetParam().method;
    params.texture.lifeSpan = 2;
    params.texture.substeps = kSubsteps;
    std::istringstream none;
    Reporter silent;
    advectSequence(params, none, silent);

    const auto pipeline = makeFlowTexture({params.texture}, {NoiseField(params.seed)});
    const auto advance = [&](const VelocityFrame& start, const VelocityFrame& end) {
        return pipeline->advance({.start = start, .end = end, .substeps = kSubsteps}).texture;
    };
    for (std::uint64_t i = 0; i < resolve(params).prerollSteps(); ++i)
        (void)advance(dense[0], dense[0]);
    for (std::size_t k = 0; k < dense.size(); ++k) {
        const auto expected = advance(dense[k], dense[std::min(k + 1, dense.size() - 1)]);
        const auto texture = readVdb(folder / fmt::format("t.{}.vdb", k)).get<openvdb::FloatGrid>("density");
        std::size_t different = 0;
        for (auto value = expected.tree()->cbeginValueOn(); value; ++value)
            different += *value != texture->tree().getValue(value.getCoord());
        EXPECT_EQ(different, 0u) << "texture " << k;
        EXPECT_EQ(texture->activeVoxelCount(), std::size_t(box.volume()));
    }
    EXPECT_FALSE(std::filesystem::exists(folder / fmt::format("t.{}.vdb", dense.size())));
}

INSTANTIATE_TEST_SUITE_P(Methods, Substeps,
                         testing::Values(Method{"Auflic", &kAuflic}, Method{"Uflic", &kUflic},
                                         Method{"Auflic2004", &kAuflic2004}, Method{"Lic", &kLic}),
                         [](const auto& method) { return method.param.name; });

/// A closed flow: no particle leaves the domain.
std::vector<VelocityFrame> eddy(int substeps)
{
    const openvdb::CoordBBox box({-16, -16, 0}, {15, 15, 7});
    return test::makeFrames(box, 2, [&](const Coord& at, int) {
        const float x = float(at[0]) + 0.5f, y = float(at[1]) + 0.5f;
        const float fade = std::max(0.0f, 1 - (x * x + y * y) / 225);
        return Vec3f(-y, x, 0) * (0.3f * fade / float(substeps));
    });
}

ScatterStats statsAfter(FlowTexture& pipeline, const std::vector<VelocityFrame>& frames)
{
    return pipeline.advance(test::stepFrom(frames, 0)).stats;
}

TEST(ReleaseTurn, ComesOnceAFrameAtAnEvenlySpreadSubstep)
{
    constexpr int kSubsteps = 12;
    std::vector<int> tiles(kSubsteps);
    for (int x = -4; x < 4; ++x) {
        for (int y = -4; y < 4; ++y) {
            for (int z = -4; z < 4; ++z) {
                int turns = 0;
                for (int step = 0; step < kSubsteps; ++step) {
                    const bool turn = isReleaseTurn({8 * x, 8 * y, 8 * z}, std::uint64_t(step), kSubsteps);
                    turns += turn;
                    tiles[std::size_t(step)] += turn;
                    EXPECT_EQ(turn, isReleaseTurn({8 * x, 8 * y, 8 * z},
                                                  std::uint64_t(step) + std::uint64_t(5) * kSubsteps, kSubsteps));
                    EXPECT_TRUE(isReleaseTurn({8 * x, 8 * y, 8 * z}, std::uint64_t(step), 1));
                }
                EXPECT_EQ(turns, 1);
            }
        }
    }
    for (const int count : tiles) // 512 / 12 = 43
        EXPECT_NEAR(count, 43, 15);
}

TEST(SubstepsOfUflic, ReleaseEachVoxelOnceAFrame)
{
    constexpr int kSubsteps = 5, kLife = 3;
    TextureParams scatter;
    scatter.method = &kUflic;
    scatter.lifeSpan = kLife;
    scatter.substeps = kSubsteps;
    const auto frames = eddy(kSubsteps);
    const std::size_t voxels = frames[0].domain.texture->voxelCount();
    const auto pipeline = makeFlowTexture({scatter}, {NoiseField(7)});
    for (int frame = 0; frame < kLife + 2; ++frame) {
        std::size_t released = 0;
        for (int part = 0; part < kSubsteps; ++part) {
            const ScatterStats stats = statsAfter(*pipeline, frames);
            released += stats.released;
            // Every seed lives for kLife frames, whatever their substeps.
            if (frame > kLife) {
                EXPECT_EQ(stats.particles + stats.released, kLife * voxels);
            }
        }
        EXPECT_EQ(released, voxels);
    }
}

/// The values on a particle must not pulsate with the frames: forgetting is spread over the substeps.
TEST(SubstepsOfAuflic, ForgetAnEqualShareInEveryStep)
{
    for (const TextureMethod* const method : {&kAuflic, &kAuflic2004}) {
        constexpr int kSubsteps = 8, kLife = 3;
        TextureParams scatter;
        scatter.lifeSpan = kLife;
        scatter.substeps = kSubsteps;
        scatter.method = method;
        const auto frames = eddy(kSubsteps);
        const auto pipeline = makeFlowTexture({scatter}, {NoiseField(7)});
        for (int i = 0; i < 2 * kLife * kSubsteps; ++i)
            (void)statsAfter(*pipeline, frames);
        double least = 1e30, most = 0;
        for (int i = 0; i < 2 * kSubsteps; ++i) {
            const ScatterStats stats = statsAfter(*pipeline, frames);
            const double values = double(stats.hits) / double(stats.deposits);
            least = std::min(least, values);
            most = std::max(most, values);
        }
        EXPECT_LT(most / least, 1.05) << method->name;
    }
}

/// In still fluid a particle takes up its own voxel's value once a frame, as it forgets that of its oldest frame, or a
/// share of all.
TEST(SubstepsOfAuflic, KeepValuesForTheirLifeSpan)
{
    constexpr int kSubsteps = 6, kLife = 4;
    const auto still = test::makeFrames({{0, 0, 0}, {15, 15, 15}}, 2, [](const Coord&, int) { return Vec3f(0); });
    for (const TextureMethod* const method : {&kAuflic, &kAuflic2004}) {
        TextureParams scatter;
        scatter.lifeSpan = kLife;
        scatter.substeps = kSubsteps;
        scatter.method = method;
        const auto pipeline = makeFlowTexture({scatter}, {NoiseField(7)});
        for (int i = 0; i < kLife * kSubsteps; ++i)
            (void)statsAfter(*pipeline, still);
        double values = 0;
        for (int i = 0; i < kSubsteps; ++i) {
            const ScatterStats stats = statsAfter(*pipeline, still);
            EXPECT_EQ(stats.particles, still[0].domain.texture->voxelCount());
            values += double(stats.hits) / double(stats.deposits) / kSubsteps;
        }
        const double remembered = method == &kAuflic ? 3.0 * kLife / 4 : kLife; // the sum of shares (1 - 4 / (3 L))^n
        EXPECT_NEAR(values, remembered, 1e-9) << method->name;
    }
}

TEST(SubstepsOfAuflic, DoNotDependOnThreads)
{
    TextureParams scatter;
    scatter.substeps = 3;
    const auto frames = test::unsteadyFlowWithHole(8);
    std::vector<std::vector<LeafValues<float>>> textures;
    for (const std::size_t threads : {1, 2, 7}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        textures.push_back(test::streamedTextures(frames, 7, scatter));
    }
    for (std::size_t run = 1; run < textures.size(); ++run) {
        for (std::size_t k = 0; k < 7; ++k) {
            for (auto value = textures[0][k].tree()->cbeginValueOn(); value; ++value)
                ASSERT_EQ(*value, textures[run][k].tree()->getValue(value.getCoord())) << k;
        }
    }
}

TEST(FrameBetween, InterpolatesWhereBothFramesHaveAVelocity)
{
    const auto frame = [](std::int64_t number, float value, const openvdb::CoordBBox& box, VelocityUnit unit) {
        VelocityFrame result;
        result.sourceFrame = double(number);
        result.file = {number, ""};
        result.unit = unit;
        result.values = openvdb::Vec3SGrid::create();
        result.values->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
        for (auto voxel = box.begin(); voxel; ++voxel)
            result.values->tree().setValue(*voxel, Vec3f(value, 0, -value));
        return result;
    };
    VelocityFrame before = frame(3, 2, {{0, 0, 0}, {9, 3, 3}}, VelocityUnit::kWorldPerSecond);
    before.values->tree().addTile(1, {64, 0, 0}, Vec3f(4, 0, 0), true); // a tile of 8^3 voxels
    const VelocityFrame after = frame(5, 12, {{5, 0, 0}, {19, 3, 3}}, VelocityUnit::kVoxelPerSecond); // 6 world/s
    const VelocityFrame between = frameBetween(before, after, 0.25);
    const auto& values = between.values->tree();
    EXPECT_EQ(values.getValue({2, 1, 1}), Vec3f(2, 0, -2));
    EXPECT_EQ(values.getValue({7, 1, 1}), Vec3f(3, 0, -3));
    EXPECT_EQ(values.getValue({17, 1, 1}), Vec3f(6, 0, -6));
    EXPECT_EQ(values.getValue({65, 2, 2}), Vec3f(4, 0, 0));
    EXPECT_EQ(values.activeVoxelCount(), 20u * 16 + 512);
    EXPECT_EQ(between.sourceFrame, 3.5);
    EXPECT_EQ(between.values->transform(), before.values->transform());
}

} // namespace
} // namespace vdblic
