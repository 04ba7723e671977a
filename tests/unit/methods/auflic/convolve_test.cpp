#include "vdblic/methods/auflic/convolve.h"

#include "methods/test_flow.h"
#include "vdblic/lic/hits.h"
#include "vdblic/noise/noise.h"
#include "vdblic/noise/noise_field.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace vdblic {
namespace {

/// Words without a hit.
LeafValues<std::int64_t> noHits(const Domain& domain)
{
    LeafValues<std::int64_t> hits(domain, 0);
    for (auto word = hits.tree()->beginValueOff(); word; ++word) {
        if (word.isVoxelValue()) word.setValue(Hits::kOutside);
    }
    return hits;
}

LeafValues<float> textureOf(const Domain& domain, const LeafValues<std::int64_t>& hits,
                            const LeafValues<std::int32_t>& input)
{
    LeafValues<float> texture(domain, 0.0f);
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf)
        convolve(domain.mask(leaf), hits[leaf], input[leaf], texture[leaf]);
    return texture;
}

RunningMean meanAfter(const Domain& domain, const LeafValues<std::int64_t>& hits, const LeafValues<std::int32_t>& input,
                      const RunningMean* before, int substeps)
{
    RunningMean after{{domain, 0.0f}, {domain, 0.0f}};
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf)
        convolve(domain.mask(leaf), hits[leaf], input[leaf], substeps,
                 before ? before->of(leaf) : MeanLeaf<const float>{}, after.of(leaf));
    return after;
}

TEST(Convolve, DividesSumsByHitsAndKeepsTheInputWhereThereAreNone)
{
    const auto frames = test::makeFrames({{0, 0, 0}, {1, 0, 0}}, 1, [](auto&, int) { return openvdb::Vec3f(0); });
    LeafValues<std::int64_t> hits = noHits(*frames[0].domain.texture);
    LeafValues<std::int32_t> input(*frames[0].domain.texture, 0);
    hits.tree()->setValue({0, 0, 0}, std::int64_t(Hits::pack(std::uint64_t(3) * 65535, 4)));
    input.tree()->setValue({1, 0, 0}, 13107);
    const auto texture = textureOf(*frames[0].domain.texture, hits, input);
    EXPECT_FLOAT_EQ(texture.tree()->getValue({0, 0, 0}), 0.75f);
    EXPECT_FLOAT_EQ(texture.tree()->getValue({1, 0, 0}), 0.2f);
}

/// Hits and inputs of their own for every voxel, on a domain whose leaves are not full.
struct VariedHits {
    std::vector<VelocityFrame> frames = test::makeFrames({{-2, 1, 0}, {9, 8, 6}}, 1, [](const openvdb::Coord& at, int) {
        const bool isHole = (at[0] + 3 * at[1] + 5 * at[2]) % 7 == 0;
        return isHole ? std::nullopt : std::optional(openvdb::Vec3f(0));
    });
    const Domain& domain = *frames[0].domain.texture;
    LeafValues<std::int64_t> words = noHits(domain);
    LeafValues<std::int32_t> input = noiseInput(domain, NoiseField(3));

    VariedHits()
    {
        for (auto word = words.tree()->beginValueOn(); word; ++word) {
            const openvdb::Coord at = word.getCoord();
            const std::uint64_t value = noiseValue(at[0], at[1], at[2], 1), count = value % 5;
            word.setValue(std::int64_t(Hits::pack(count * noiseValue(at[0], at[1], at[2], 2) + count / 3, count)));
        }
    }
    [[nodiscard]] std::uint64_t count(const openvdb::Coord& at) const
    {
        return Hits::count(std::uint64_t(words.tree()->getValue(at)));
    }
    /// The mean of a voxel's hits, or its input.
    [[nodiscard]] float mean(const openvdb::Coord& at) const
    {
        const double sum = double(Hits::sum(std::uint64_t(words.tree()->getValue(at))));
        return (count(at) > 0 ? float(sum / double(count(at))) : float(input.tree()->getValue(at))) / 65535.0f;
    }
};

TEST(Convolve, EveryVoxelHasTheMeanOfItsHits)
{
    const VariedHits hits;
    const auto texture = textureOf(hits.domain, hits.words, hits.input);
    for (auto value = texture.tree()->cbeginValueOn(); value; ++value)
        ASSERT_EQ(*value, hits.mean(value.getCoord())) << value.getCoord();
    for (auto value = texture.tree()->cbeginValueOff(); value; ++value)
        ASSERT_EQ(*value, 0);
}

TEST(RunningMean, EveryVoxelMovesByTheShareOfItsNewHits)
{
    const VariedHits hits;
    const RunningMean before{{hits.domain, 0.25f}, {hits.domain, 6.0f}};
    const RunningMean after = meanAfter(hits.domain, hits.words, hits.input, &before, 2);
    for (auto value = after.mean.tree()->cbeginValueOn(); value; ++value) {
        const openvdb::Coord at = value.getCoord();
        const auto count = float(hits.count(at));
        const float moved = 0.25f + (hits.mean(at) - 0.25f) * (count / (2 + count));
        ASSERT_EQ(*value, count > 0 ? moved : 0.25f) << at;
        ASSERT_EQ(after.weight.tree()->getValue(at), 2 + count) << at;
    }
    for (auto value = after.mean.tree()->cbeginValueOff(); value; ++value) {
        ASSERT_EQ(*value, 0);
        ASSERT_EQ(after.weight.tree()->getValue(value.getCoord()), 0);
    }
}

TEST(RunningMean, CountsOlderHitsLess)
{
    constexpr int kSubsteps = 3; // weights halve in every step
    const auto frames = test::makeFrames({{0, 0, 0}, {1, 0, 0}}, 1, [](auto&, int) { return openvdb::Vec3f(0); });
    const Domain& domain = *frames[0].domain.texture;
    const LeafValues<std::int32_t> input(domain, 13107); // 0.2
    const auto step = [&](std::uint64_t sum, std::uint64_t count, const RunningMean* before) {
        LeafValues<std::int64_t> hits = noHits(domain);
        hits.tree()->setValue({0, 0, 0}, std::int64_t(Hits::pack(sum * 65535, count)));
        return meanAfter(domain, hits, input, before, kSubsteps);
    };
    const RunningMean first = step(3, 4, nullptr), second = step(1, 1, &first), third = step(0, 0, &second);
    EXPECT_FLOAT_EQ(first.mean.tree()->getValue({0, 0, 0}), 0.75f);
    EXPECT_FLOAT_EQ(second.mean.tree()->getValue({0, 0, 0}), (3 * 0.5f + 1) / (4 * 0.5f + 1));
    EXPECT_EQ(second.weight.tree()->getValue({0, 0, 0}), 3);
    EXPECT_EQ(third.mean.tree()->getValue({0, 0, 0}), second.mean.tree()->getValue({0, 0, 0}));
    EXPECT_EQ(third.weight.tree()->getValue({0, 0, 0}), 1.5f);
    EXPECT_FLOAT_EQ(third.mean.tree()->getValue({1, 0, 0}), 0.2f);
    EXPECT_EQ(third.weight.tree()->getValue({1, 0, 0}), 0);
}

TEST(RunningMean, OnAnotherDomainStartsNewVoxelsFromTheirInput)
{
    const auto from = test::makeFrames({{0, 0, 0}, {9, 0, 0}}, 1, [](auto&, int) { return openvdb::Vec3f(0); });
    const auto to = test::makeFrames({{5, 0, 0}, {12, 0, 0}}, 1, [](auto&, int) { return openvdb::Vec3f(0); });
    const LeafValues<std::int32_t> before(*from[0].domain.texture, 6554),
        input(*to[0].domain.texture, 13107); // 0.1, 0.2
    Convolution convolution(*from[0].domain.texture, before, 2,
                            RunningMean{{*from[0].domain.texture, 0.5f}, {*from[0].domain.texture, 6.0f}});
    const std::vector<std::int64_t> noHits(LeafVoxel::kCount, 0);
    for (std::size_t leaf = 0; leaf < from[0].domain.texture->leafCount(); ++leaf)
        convolution.take(leaf, noHits.data());
    EXPECT_EQ(convolution.texture().tree()->getValue({3, 0, 0}), 0.5f);
    const RunningMean moved = convolution.meanOn(*to[0].domain.texture, input).value();
    EXPECT_EQ(moved.mean.tree()->activeVoxelCount(), 8u);
    for (int x = 5; x <= 12; ++x) {
        EXPECT_FLOAT_EQ(moved.mean.tree()->getValue({x, 0, 0}), x < 10 ? 0.5f : 0.2f) << x;
        EXPECT_EQ(moved.weight.tree()->getValue({x, 0, 0}), x < 10 ? 2 : 0) << x; // a third of the weight is kept
    }
}

} // namespace
} // namespace vdblic
