#include "vdblic/look/kinds.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace vdblic {
namespace {

TransferParams ofKinds(std::size_t sources)
{
    TransferParams params;
    params.kinds.resize(sources + 1);
    return params;
}

TEST(Kinds, HaveColoursOfTheirOwnOverAllOfTheirPartOfTheRange)
{
    TransferParams params = ofKinds(16);
    colorByKind(params);
    params.opacity = {{0, 1}};
    const TransferFunction transfer(params);
    const auto colorOf = [&](double value) { return transfer.displayColor(transfer.colorAxis().position(value)); };
    for (int i = 0; i <= 16; ++i) {
        EXPECT_LT(glm::length(colorOf(i - 0.45) - colorOf(i)), 1e-9) << i;
        EXPECT_LT(glm::length(colorOf(i + 0.45) - colorOf(i)), 1e-9) << i;
        for (int j = 0; j < i; ++j)
            EXPECT_GT(glm::length(colorOf(i) - colorOf(j)), 0.12) << i << " and " << j;
    }
    const glm::dvec3 none = colorOf(0);
    EXPECT_LT(glm::length(none - none.x), 0.1);
}

TEST(Kinds, TakeColoursThatAreGiven)
{
    TransferParams params = ofKinds(1);
    params.colors = {{0, {1, 0, 0}}, {0.5, {1, 0, 0}}, {0.5, {0, 0, 1}}, {1, {0, 0, 1}}};
    TransferParams again = params;
    colorByKind(again);
    EXPECT_EQ(colorsText(again.colors), colorsText(params.colors));
    colorByKind(again); // as a transfer function that was written and read
    EXPECT_EQ(colorsText(again.colors), colorsText(params.colors));
    EXPECT_EQ(again.kinds.size(), 2);
}

TEST(Kinds, AreNumbersInARangeOfOnesOwn)
{
    TransferParams params = ofKinds(2);
    params.range = {0, 5};
    colorByKind(params);
    EXPECT_TRUE(params.kinds.empty());
    EXPECT_TRUE(params.colors.empty());
}

TEST(Kinds, AreEquallyOpaqueAndWhatIsOfNoneIsFainter)
{
    VolumeSamples samples;
    samples.texture.assign(1000, 1.0f);
    samples.driver.assign(1000, 0.0f);
    samples.driver[7] = 1;
    samples.driver[8] = 2;
    LookParams params;
    params.transfer.kinds = {"none", "a", "b"};
    std::fill_n(samples.texture.begin() + 500, 500, 0.0f); // a texture of one value has no structure
    const Look look = chooseLook(params, samples, 100);
    const auto opacity = [&](double value) {
        return look.transfer.opacityAt(look.transfer.opacityAxis().position(value));
    };
    EXPECT_GT(opacity(0), 0);
    EXPECT_GT(opacity(1), 2 * opacity(0));
    EXPECT_EQ(opacity(1), opacity(2));
    EXPECT_EQ(opacity(0.6), opacity(2.4));
}

} // namespace
} // namespace vdblic
