#include "vdblic/lic/convolve.h"

#include "lic/test_flow.h"
#include "vdblic/lic/hits.h"
#include "vdblic/lic/scatter.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace vdblic {
namespace {

TEST(Convolve, DividesSumsByHitsAndKeepsTheInputWhereThereAreNone)
{
    const auto frames = test::makeFrames({{0, 0, 0}, {1, 0, 0}}, 1, [](auto&, int) { return openvdb::Vec3f(0); });
    const LeafValues<std::int64_t> accumulator = makeAccumulator(*frames[0].domain);
    LeafValues<std::int32_t> input(*frames[0].domain, 0);
    accumulator.tree()->setValue({0, 0, 0}, std::int64_t(Hits::pack(std::uint64_t(3) * 65535, 4)));
    input.tree()->setValue({1, 0, 0}, 13107);
    const auto texture = convolve(*frames[0].domain, accumulator, input);
    EXPECT_FLOAT_EQ(texture.tree()->getValue({0, 0, 0}), 0.75f);
    EXPECT_FLOAT_EQ(texture.tree()->getValue({1, 0, 0}), 0.2f);
}

TEST(RunningMean, CountsOlderHitsLess)
{
    constexpr int kSubsteps = 3; // weights halve in every step
    const auto frames = test::makeFrames({{0, 0, 0}, {1, 0, 0}}, 1, [](auto&, int) { return openvdb::Vec3f(0); });
    const Domain& domain = *frames[0].domain;
    const LeafValues<std::int32_t> input(domain, 13107); // 0.2
    const auto step = [&](std::uint64_t sum, std::uint64_t count, const RunningMean* before) {
        const LeafValues<std::int64_t> accumulator = makeAccumulator(domain);
        accumulator.tree()->setValue({0, 0, 0}, std::int64_t(Hits::pack(sum * 65535, count)));
        return convolve(domain, accumulator, input, before, kSubsteps);
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
    const RunningMean mean{{*from[0].domain, 0.5f}, {*from[0].domain, 7.0f}};
    const LeafValues<std::int32_t> input(*to[0].domain, 13107); // 0.2
    const RunningMean moved = onDomain(*to[0].domain, input, *from[0].domain, mean);
    EXPECT_EQ(moved.mean.tree()->activeVoxelCount(), 8u);
    for (int x = 5; x <= 12; ++x) {
        EXPECT_FLOAT_EQ(moved.mean.tree()->getValue({x, 0, 0}), x < 10 ? 0.5f : 0.2f) << x;
        EXPECT_EQ(moved.weight.tree()->getValue({x, 0, 0}), x < 10 ? 7 : 0) << x;
    }
}

} // namespace
} // namespace vdblic
