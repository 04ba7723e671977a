#include "vdblic/coherence/estimate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace vdblic {
namespace {

// Quantiles of Student's distribution: tables, 0.975.
TEST(EstimateMean, HasStudentsInterval)
{
    const Estimate three = estimateMean({1, NAN, 2, 3});
    EXPECT_EQ(three.frames, 3);
    EXPECT_DOUBLE_EQ(three.mean, 2);
    EXPECT_NEAR(three.halfWidth, 4.30265272975 / std::sqrt(3), 1e-10);
    std::vector<double> many;
    many.reserve(21);
    for (int i = 0; i < 21; ++i)
        many.push_back(i % 2 ? 1 : -1);
    const Estimate estimate = estimateMean(many);
    const double deviation = std::sqrt((21 - 1 / 21.0) / 20);
    EXPECT_NEAR(estimate.halfWidth, 2.08596344726 * deviation / std::sqrt(21), 1e-10);
}

TEST(EstimateMean, LeavesOutWhatIsUnknown)
{
    EXPECT_DOUBLE_EQ(estimateMean({0.5}).mean, 0.5);
    EXPECT_TRUE(std::isnan(estimateMean({0.5}).halfWidth));
    EXPECT_TRUE(std::isnan(estimateMean({}).mean));
    EXPECT_EQ(estimateMean({NAN, NAN}).frames, 0);
    EXPECT_TRUE(std::isnan(estimateMean({NAN}).mean));
    EXPECT_EQ(estimateMean({2, 2}).halfWidth, 0);
}

} // namespace
} // namespace vdblic
