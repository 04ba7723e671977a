#include "vdblic/methods/auflic/scatter.h"

#include "methods/auflic/literal_lic.h"
#include "methods/test_flow.h"
#include "vdblic/core/errors.h"
#include "vdblic/field/slabs.h"
#include "vdblic/lic/hits.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

constexpr int kScatterSteps = 9;

/// Every voxel of every texture, bit for bit.
void expectEqual(const std::vector<LeafValues<float>>& a, const std::vector<LeafValues<float>>& b)
{
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) {
        ASSERT_TRUE(a[k].tree()->hasSameTopology(*b[k].tree())) << "step " << k;
        std::size_t differing = 0;
        for (auto value = a[k].tree()->cbeginValueOn(); value; ++value) {
            differing += *value != b[k].tree()->getValue(value.getCoord());
        }
        ASSERT_EQ(differing, 0u) << "step " << k << " of " << a[k].tree()->activeVoxelCount() << " voxels";
    }
}

class EqualsLiteral : public testing::TestWithParam<TextureParams> {};

TEST_P(EqualsLiteral, OnAnUnsteadyFlowWithAMovingHole)
{
    const auto frames = test::unsteadyFlowWithHole(kScatterSteps + 1);
    const bool history = GetParam().method == &kAuflic;
    expectEqual(test::streamedTextures(frames, kScatterSteps, GetParam()),
                history ? test::literalTexturesWithHistory(frames, kScatterSteps, GetParam())
                        : test::literalTextures(frames, kScatterSteps, GetParam()));
}

TextureParams params(const TextureMethod* method, int lifeSpan, float window = 0.25f)
{
    TextureParams result;
    result.method = method;
    result.lifeSpan = lifeSpan;
    result.releaseWindow = window;
    return result;
}

std::string nameOf(const testing::TestParamInfo<TextureParams>& info)
{
    return fmt::format("Life{}Window{}", info.param.lifeSpan, int(100 * info.param.releaseWindow));
}

INSTANTIATE_TEST_SUITE_P(Uflic, EqualsLiteral,
                         testing::Values(params(&kUflic, 1), params(&kUflic, 4), params(&kUflic, 12)), nameOf);
INSTANTIATE_TEST_SUITE_P(Auflic2004, EqualsLiteral,
                         testing::Values(params(&kAuflic2004, 1), params(&kAuflic2004, 4),
                                         params(&kAuflic2004, 4, 1.0f), params(&kAuflic2004, 7, 0.5f)),
                         nameOf);

INSTANTIATE_TEST_SUITE_P(Auflic, EqualsLiteral,
                         testing::Values(params(&kAuflic, 1, 0.25f), params(&kAuflic, 4, 0.25f),
                                         params(&kAuflic, 7, 1.0f)),
                         nameOf);

/// Textures of runs on one, two and seven threads.
void expectSameForAnyThreads(const std::vector<VelocityFrame>& frames, const TextureParams& method)
{
    const int steps = int(frames.size()) - 1;
    std::vector<std::vector<LeafValues<float>>> runs;
    for (const std::size_t threads : {1, 2, 7}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        runs.push_back(test::streamedTextures(frames, steps, method));
    }
    expectEqual(runs[0], runs[1]);
    expectEqual(runs[0], runs[2]);
}

/// A channel of many leaves with a few voxels across, in an unsteady flow along it of less than 5 voxels a step.
std::vector<VelocityFrame> channelFlow(int frames)
{
    return test::makeFrames({{0, -3, 5}, {4, 2, 324}}, frames, [](const openvdb::Coord& at, int frame) {
        const float z = 0.3f * float(at[2]), t = 0.8f * float(frame);
        return openvdb::Vec3f(0.4f * std::sin(z + t), 0.4f * std::cos(2 * z), 2.5f + 2 * std::sin(0.1f * z - t));
    });
}

TEST(Scatter, GivesTheSameTexturesForAnyNumberOfThreads)
{
    const auto frames = channelFlow(kScatterSteps + 1);
    for (const TextureParams& method : {params(&kUflic, 4), params(&kAuflic2004, 4), params(&kAuflic, 4, 0.5f)})
        expectSameForAnyThreads(frames, method);
}

TEST(Scatter, GivesTheSameTexturesForAnyNumberOfThreadsInAMovingHole)
{
    expectSameForAnyThreads(test::unsteadyFlowWithHole(kScatterSteps + 1), params(&kAuflic, 4, 0.5f));
}

TEST(Scatter, GivesTheSameTexturesForAnyNumberOfSlabs)
{
    // With one thread slabs are thin, with seven they are one. Paths lead through up to three of the thin ones.
    const auto frames = test::makeFrames({{0, 0, 0}, {20, 17, 180}}, 5, [](const openvdb::Coord& at, int frame) {
        const float z = 0.1f * float(at[2]) - 0.4f * float(frame);
        const bool isHole = (at[2] / 40 + at[0] / 4) % 7 == 0;
        const openvdb::Vec3f velocity(std::sin(z), std::cos(2 * z), 20 + 19 * std::sin(z));
        return isHole ? std::nullopt : std::optional(velocity);
    });
    {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
        ASSERT_EQ(Slabs(*frames[0].domain.texture).size(), 3u);
    }
    for (const TextureParams& method : {params(&kUflic, 4), params(&kAuflic, 4, 0.25f)})
        expectSameForAnyThreads(frames, method);
}

TEST(Scatter, ASinkThatTakesInMoreThanFitsIsTheSameForAnyNumberOfThreads)
{
    // Thousands of particles end each step in one voxel, where a particle can take over the values of 255 seeds only.
    const auto frames = test::makeFrames({{-20, -20, -20}, {20, 20, 20}}, 4, [](const openvdb::Coord& at, int) {
        return openvdb::Vec3f(at.asVec3s()) * -3;
    });
    expectSameForAnyThreads(frames, params(&kAuflic, 4, 0.25f));
}

/// A step over a domain, with its input and its hits.
struct OneStep {
    std::vector<VelocityFrame> frames;
    VelocityField field;
    LeafValues<std::int32_t> input;
    LeafValues<std::int64_t> hits;

    explicit OneStep(std::vector<VelocityFrame> flow) : frames(std::move(flow))
    {
        const FlowStep step = test::stepFrom(frames, 0);
        field.build(step.start.domain, step.startVelocities(), step.endVelocities());
        input = noiseInput(*step.start.domain.texture, NoiseField(3));
        hits = LeafValues<std::int64_t>(*step.start.domain.texture, -1);
    }
    ScatterStats by(Scatter& scatter)
    {
        const auto take = [&](std::size_t leaf, const std::int64_t* words) {
            std::copy_n(words, Domain::kLeafVoxels, hits[leaf]);
        };
        StageClock clock;
        return scatter.step(field, input, take, field.domain(), 1, kSoleOwner, clock);
    }
};

TEST(Scatter, EveryVoxelReleasesExactlyOneSeedAStep)
{
    OneStep step(test::unsteadyFlowWithHole(2));
    const std::size_t voxels = step.field.domain().voxelCount();
    for (const TextureParams& method : {params(&kUflic, 4), params(&kAuflic2004, 4), params(&kAuflic, 4, 0.25f)}) {
        Scatter scatter(method);
        for (int k = 0; k < 6; ++k) {
            const ScatterStats stats = step.by(scatter);
            EXPECT_EQ(stats.released + stats.reused + stats.copied, voxels) << "step " << k;
        }
    }
}

TEST(Scatter, AuflicKeepsFewerParticlesThanUflic)
{
    OneStep step(test::unsteadyFlowWithHole(2));
    std::size_t particles[2] = {0, 0};
    for (const TextureMethod* const method : {&kUflic, &kAuflic2004}) {
        Scatter scatter(params(method, 8));
        for (int k = 0; k < 10; ++k)
            particles[method == &kAuflic2004] = step.by(scatter).particles;
    }
    EXPECT_LT(2 * particles[1], particles[0]);
    EXPECT_GT(particles[1], 0u);
}

TEST(Scatter, AtRestEachVoxelIsHitByItsOwnSeedsOnly)
{
    OneStep step(test::makeFrames({{0, 0, 0}, {10, 9, 8}}, 2, [](auto&, int) { return openvdb::Vec3f(0); }));
    Scatter scatter(params(&kUflic, 3));
    for (int k = 0; k < 5; ++k) {
        step.by(scatter);
        const std::uint64_t expected = std::uint64_t(std::min(k + 1, 3));
        for (auto value = step.hits.tree()->cbeginValueOn(); value; ++value) {
            const auto word = std::uint64_t(*value);
            ASSERT_EQ(Hits::count(word), expected);
            ASSERT_EQ(Hits::sum(word), expected * std::uint64_t(step.input.tree()->getValue(value.getCoord())));
        }
    }
}

TEST(Scatter, AVoxelThatOverflowsIsReported)
{
    // Some hundred paths end in a sink, and a value of a long life has a large weight.
    OneStep step(test::makeFrames({{-12, -12, -12}, {12, 12, 12}}, 2,
                                  [](const openvdb::Coord& at, int) { return openvdb::Vec3f(at.asVec3s()) * -1.6f; }));
    TextureParams method = params(&kAuflic, 1000, 0.25f);
    Scatter within(method);
    step.by(within);
    std::uint64_t most = 0;
    for (auto word = step.hits.tree()->cbeginValueOn(); word; ++word)
        most = std::max(most, Hits::count(std::uint64_t(*word)));
    ASSERT_GT(2 * most, Hits::kCountMask + 1); // twice as many hits overflow
    method.pathline.sampleSpacing /= 2;
    Scatter beyond(method);
    EXPECT_THROW(step.by(beyond), InputError);
}

TEST(Scatter, RefusesParametersOutOfRange)
{
    EXPECT_THROW(Scatter(params(&kUflic, 0)), ParameterError);
    EXPECT_THROW(Scatter(params(&kAuflic2004, 4, 0.0f)), ParameterError);
    EXPECT_THROW(Scatter(params(&kAuflic2004, 4, std::nanf(""))), ParameterError);
}

} // namespace
} // namespace vdblic
