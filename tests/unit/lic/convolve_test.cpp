#include "vdblic/lic/convolve.h"

#include "lic/test_flow.h"
#include "vdblic/lic/hits.h"
#include "vdblic/lic/scatter.h"

#include <gtest/gtest.h>

namespace vdblic {
namespace {

TEST(Convolve, DividesSumsByHitsAndKeepsTheInputWhereThereAreNone)
{
    const auto frames = test::makeFrames({{0, 0, 0}, {1, 0, 0}}, 1, [](auto&, int) { return openvdb::Vec3f(0); });
    const LeafValues<std::int64_t> accumulator = makeAccumulator(*frames[0].domain);
    LeafValues<std::int32_t> input(*frames[0].domain, 0);
    accumulator.tree()->setValue({0, 0, 0}, std::int64_t(Hits::pack(3 * 65535, 4)));
    input.tree()->setValue({1, 0, 0}, 13107);
    const auto texture = convolve(*frames[0].domain, accumulator, input);
    EXPECT_FLOAT_EQ(texture.tree()->getValue({0, 0, 0}), 0.75f);
    EXPECT_FLOAT_EQ(texture.tree()->getValue({1, 0, 0}), 0.2f);
}

} // namespace
} // namespace vdblic
