#include "vdblic/coherence/coherence_report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <string>

namespace vdblic {
namespace {

SequenceCoherence fallingCurves()
{
    SequenceCoherence coherence{};
    coherence.lags = coherenceLags({2, 2, 2});
    for (const double lag : coherence.lags) {
        coherence.raw.along.push_back(std::exp(-lag / 8));
        coherence.smoothed.along.push_back(std::exp(-lag / 10));
        coherence.raw.across.push_back(std::exp(-lag / 1.5));
        coherence.smoothed.across.push_back(std::exp(-lag / 2));
    }
    return coherence;
}

std::size_t count(const std::string& text, const std::string& part)
{
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++found;
    return found;
}

TEST(CoherencePlot, IsTheSameEveryTime)
{
    EXPECT_EQ(toSvg(fallingCurves()), toSvg(fallingCurves()));
}

TEST(CoherencePlot, HasFourCurvesAndTheirKey)
{
    const std::string svg = toSvg(fallingCurves());
    EXPECT_NE(svg.find("</svg>"), std::string::npos);
    EXPECT_EQ(count(svg, "stroke-width:2;"), 8u);
}

TEST(CoherencePlot, OfUnknownFiguresStopsThere)
{
    SequenceCoherence coherence = fallingCurves();
    const std::size_t whole = toSvg(coherence).size();
    for (std::size_t lag = 4; lag < coherence.lags.size(); ++lag)
        coherence.raw.along[lag] = NAN;
    const std::string svg = toSvg(coherence);
    EXPECT_LT(svg.size(), whole);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
}

} // namespace
} // namespace vdblic
