#include "vdblic/lic/hits.h"

#include "methods/test_flow.h"
#include "vdblic/methods/flow_texture.h"
#include "vdblic/methods/registry.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;

/// A step of a method that is asked for its hits.
TextureFrame stepWithHits(FlowTexture& texture, const std::vector<VelocityFrame>& frames, std::size_t k)
{
    FlowStep step = test::stepFrom(frames, k);
    step.withHits = true;
    return texture.advance(step);
}

TextureParams scattering(const TextureMethod* method, int lifeSpan)
{
    TextureParams params;
    params.method = method;
    params.lifeSpan = lifeSpan;
    return params;
}

TEST(HitsOfVoxels, AreRoundedAndZeroOnlyWithoutAHit)
{
    EXPECT_EQ(Hits::values(Hits::pack(9, 0), 32), 0);
    EXPECT_EQ(Hits::values(std::uint64_t(Hits::kOutside), 32), 0);
    EXPECT_EQ(Hits::values(Hits::pack(9, 1), 32), 1);
    EXPECT_EQ(Hits::values(Hits::pack(9, 47), 32), 1);
    EXPECT_EQ(Hits::values(Hits::pack(9, 48), 32), 2);
    EXPECT_EQ(Hits::values(Hits::pack(1 << 20, 5), 1), 5);
    EXPECT_EQ(Hits::values(Hits::pack(0, Hits::kCountMask), 1), std::int32_t(Hits::kCountMask));
}

TEST(HitsOfVoxels, AreThereIfAskedFor)
{
    const auto frames = test::unsteadyFlowWithHole(2);
    const auto texture = makeFlowTexture({scattering(&kUflic, 2)}, {NoiseField(7)});
    EXPECT_FALSE(texture->advance(test::stepFrom(frames, 0)).hits.tree());
}

TEST(HitsOfVoxels, OfAUniformFlowAreTheSamplesOfEachSeed)
{
    // A path of two voxels has five samples, 0.4 voxels apart: one in its own voxel, three in the next, one in the
    // last.
    const auto frames =
        test::makeFrames({{-9, 0, 3}, {20, 6, 8}}, 3, [](const Coord&, int) { return openvdb::Vec3f(2, 0, 0); });
    const auto texture = makeFlowTexture({scattering(&kUflic, 1)}, {NoiseField(7)});
    for (std::size_t k = 0; k < 2; ++k) {
        const LeafValues<std::int32_t> hits = stepWithHits(*texture, frames, k).hits;
        EXPECT_EQ(hits.tree()->activeVoxelCount(), frames[0].domain.texture->voxelCount());
        for (auto count = hits.tree()->cbeginValueOn(); count; ++count) {
            const int upstream = count.getCoord()[0] + 9;
            ASSERT_EQ(*count, upstream == 0 ? 1 : upstream == 1 ? 4 : 5) << count.getCoord();
        }
    }
}

TEST(HitsOfVoxels, AtRestAreThoseOfTheirOwnSeeds)
{
    const auto frames = test::makeFrames({{0, 0, 0}, {10, 9, 8}}, 7, [](auto&, int) { return openvdb::Vec3f(0); });
    const auto texture = makeFlowTexture({scattering(&kUflic, 3)}, {NoiseField(7)});
    for (std::size_t k = 0; k < 6; ++k) {
        const LeafValues<std::int32_t> hits = stepWithHits(*texture, frames, k).hits;
        for (auto count = hits.tree()->cbeginValueOn(); count; ++count)
            ASSERT_EQ(*count, std::int32_t(std::min<std::size_t>(k + 1, 3)));
    }
}

TEST(HitsOfVoxels, AddUpToThoseOfTheStep)
{
    const auto frames = test::unsteadyFlowWithHole(6);
    for (const TextureMethod* const method : {&kUflic, &kAuflic2004, &kAuflic}) {
        const auto texture = makeFlowTexture({scattering(method, 3)}, {NoiseField(7)});
        for (std::size_t k = 0; k < 5; ++k) {
            const TextureFrame step = stepWithHits(*texture, frames, k);
            std::size_t sum = 0, empty = 0, voxels = 0;
            for (auto count = step.hits.tree()->cbeginValueOn(); count; ++count, ++voxels) {
                sum += std::size_t(*count);
                empty += *count == 0;
            }
            EXPECT_EQ(voxels, frames[k].domain.texture->voxelCount());
            EXPECT_EQ(empty, step.stats.emptyVoxels);
            if (method == &kAuflic) { // each voxel's are rounded
                EXPECT_NEAR(double(sum), double(step.stats.hits), 0.05 * double(step.stats.hits));
            } else {
                EXPECT_EQ(sum, step.stats.hits);
            }
            EXPECT_GT(sum, voxels);
        }
    }
}

TEST(HitsOfVoxels, AreTheSameForAnyNumberOfThreads)
{
    const auto frames = test::unsteadyFlowWithHole(4);
    std::vector<std::vector<std::int32_t>> counts;
    for (const std::size_t threads : {1, 7}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        const auto texture = makeFlowTexture({}, {NoiseField(7)});
        counts.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            const LeafValues<std::int32_t> hits = stepWithHits(*texture, frames, k).hits;
            for (auto count = hits.tree()->cbeginValueOn(); count; ++count)
                counts.back().push_back(*count);
        }
    }
    EXPECT_EQ(counts[0], counts[1]);
}

} // namespace
} // namespace vdblic
