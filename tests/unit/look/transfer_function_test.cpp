#include "vdblic/look/transfer_function.h"

#include "vdblic/core/errors.h"
#include "vdblic/image/color_map.h"

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

namespace vdblic {
namespace {

void expectColor(const glm::dvec3& color, double red, double green, double blue, double tolerance)
{
    EXPECT_NEAR(color.r, red, tolerance);
    EXPECT_NEAR(color.g, green, tolerance);
    EXPECT_NEAR(color.b, blue, tolerance);
}

TransferParams grayBetween(const std::vector<OpacityPoint>& opacity, double low, double high)
{
    return {.colorMap = "gray", .opacity = opacity, .range = std::array{low, high}};
}

TEST(ColorMap, HasThePublishedColors)
{
    // matplotlib's viridis to half a step of eight bits; turbo's and Moreland's ends and middle.
    expectColor(colorMap("viridis", 0), 0.267004, 0.004874, 0.329415, 0.003);
    expectColor(colorMap("viridis", 0.5), 0.127568, 0.566949, 0.550556, 0.003);
    expectColor(colorMap("viridis", 1), 0.993248, 0.906157, 0.143936, 0.003);
    expectColor(colorMap("turbo", 0), 0.18995, 0.07176, 0.23217, 0.003);
    expectColor(colorMap("turbo", 1), 0.47960, 0.01583, 0.01055, 0.006);
    expectColor(colorMap("coolwarm", 0), 59 / 255., 76 / 255., 192 / 255., 1e-12);
    expectColor(colorMap("coolwarm", 0.5), 221 / 255., 221 / 255., 221 / 255., 1e-12);
    expectColor(colorMap("coolwarm", 1), 180 / 255., 4 / 255., 38 / 255., 1e-12);
    expectColor(colorMap("gray", 0.25), 0.25, 0.25, 0.25, 1e-12);
    expectColor(colorMap("gray", 7), 1, 1, 1, 1e-12);
    EXPECT_THROW((void)colorMap("rainbow", 0), ParameterError);
}

TEST(ColorMap, ConvertsBetweenDisplayAndLinearLight)
{
    EXPECT_NEAR(linearFromDisplay(0.5), 0.214041, 1e-6);
    EXPECT_NEAR(linearFromDisplay(0.04), 0.04 / 12.92, 1e-12);
    for (const double value : {0.0, 0.002, 0.04, 0.3, 1.0}) {
        EXPECT_NEAR(displayFromLinear(linearFromDisplay(value)), value, 1e-7);
    }
}

TEST(TransferFunction, TabulatesColorAndExtinction)
{
    const TransferFunction transfer(grayBetween({{0.25, 0}, {0.75, 0.5}}, 10, 20));
    const auto at = [&](float driver) { return transfer.table()[transfer.entries(broadcast8(driver))[0]]; };
    // Opacity is constant before the first point and after the last, linear between.
    EXPECT_EQ(at(12).extinction, 0);
    EXPECT_NEAR(at(15).extinction, -std::log(0.75), 1e-3);
    EXPECT_NEAR(at(19).extinction, std::log(2.0), 1e-6);
    // Display gray of one half is 0.214 of the light.
    EXPECT_NEAR(at(15).red, 0.214, 1e-3);
    EXPECT_NEAR(at(20).blue, 1, 1e-6);
}

TEST(TransferFunction, KeepsToItsTableForAnyDriver)
{
    const TransferFunction transfer(grayBetween({{0, 0.5}}, 10, 20));
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const Int8 entries = transfer.entries(Float8{-kInfinity, -1e30f, 10, 20, 1e30f, kInfinity, 15, 9.99f});
    const int expected[] = {0, 0, 0, 1023, 1023, 1023, 512, 0};
    for (int i = 0; i < 8; ++i)
        EXPECT_EQ(entries[i], expected[i]) << i;
    const int entry = transfer.entries(broadcast8(std::numeric_limits<float>::quiet_NaN()))[0];
    EXPECT_TRUE(entry >= 0 && entry < TransferFunction::kEntries) << entry;
}

TEST(TransferFunction, AFullOpacityIsFinite)
{
    const TransferFunction transfer(grayBetween({{0, 1}}, 0, 1));
    EXPECT_TRUE(std::isfinite(transfer.table()[0].extinction));
    EXPECT_GT(transfer.table()[0].extinction, 10);
}

TEST(TransferFunction, KnowsWhichDriversContribute)
{
    const TransferFunction transfer(grayBetween({{0, 0}, {0.4, 0}, {0.5, 1}, {0.6, 0}}, 0, 1));
    EXPECT_FALSE(transfer.contributes(-3, 0.39f));
    EXPECT_FALSE(transfer.contributes(0.61f, 5));
    EXPECT_TRUE(transfer.contributes(0.1f, 0.9f));
    EXPECT_TRUE(transfer.contributes(0.5f, 0.5f));
    EXPECT_TRUE(transfer.contributes(0.41f, 0.42f));
}

TEST(TransferFunction, ReadsAndWritesOpacityPoints)
{
    const std::vector<OpacityPoint> points = parseOpacity("0:0,0.25:0.1,1:0.8");
    ASSERT_EQ(points.size(), 3u);
    EXPECT_EQ(points[1].position, 0.25);
    EXPECT_EQ(points[1].opacity, 0.1);
    EXPECT_EQ(opacityText(points), "0:0,0.25:0.1,1:0.8");
    for (const char* bad : {"", "0", "0:", ":1", "0:0,", "0:0 1:1", "0:nan", "nan:0", "0:1.5", "-1:0", "0.5:0,0.4:1"}) {
        EXPECT_THROW((void)parseOpacity(bad), ParameterError) << bad;
    }
}

TEST(TransferFunction, ReadsColorPoints)
{
    const std::vector<ColorPoint> points = parseColors("0:#000000,0.25:#ff8000,1:#0A0bfF");
    ASSERT_EQ(points.size(), 3u);
    EXPECT_EQ(points[1].position, 0.25);
    expectColor(points[1].color, 1, 128 / 255., 0, 1e-12);
    expectColor(points[2].color, 10 / 255., 11 / 255., 1, 1e-12);
    TransferParams params = grayBetween({{0, 1}}, 0, 1);
    params.colors = points;
    const TransferFunction transfer(params);
    expectColor(transfer.displayColor(0.125), 0.5, 64 / 255., 0, 1e-12);
    EXPECT_EQ(transfer.colorMapName(), "points");
    for (const char* bad :
         {"", "0", "0:", ":#000000", "0:#000000,", "0:000000", "0:#00000", "0:#0000000", "0:#00000g", "0:#+00000",
          "0:#0x0000", "nan:#000000", "-1:#000000", "0.5:#000000,0.4:#000000", "0:#000000 1:#ffffff"}) {
        EXPECT_THROW((void)parseColors(bad), ParameterError) << bad;
    }
}

TEST(TransferFunction, RefusesARangeThatDoesNotRise)
{
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    for (const auto& range : {std::array{1.0, 1.0}, {2.0, 1.0}, {kNan, 1.0}, {0.0, kNan}, {0.0, HUGE_VAL}}) {
        EXPECT_THROW((TransferParams{.range = range}.validate()), ParameterError) << range[0] << " " << range[1];
    }
    EXPECT_THROW((TransferParams{.colorMap = "rainbow"}.validate()), ParameterError);
}

TEST(TransferFunction, SpreadsPowersEvenlyOnALogarithmicScale)
{
    TransferParams params = grayBetween({{0, 0}, {1, 0.9}}, 0.01, 10);
    params.colorScale = ValueScale::kLogarithmic;
    const TransferFunction transfer(params);
    const auto at = [&](float driver) { return transfer.table()[transfer.entries(broadcast8(driver))[0]]; };
    for (const auto& [value, position] :
         {std::pair{0.01f, 0.0}, {0.1f, 1 / 3.}, {0.316228f, 0.5}, {1, 2 / 3.}, {10, 1.0}}) {
        EXPECT_NEAR(displayFromLinear(at(value).red), position, 1e-3) << value;
        EXPECT_NEAR(-std::expm1(-at(value).extinction), 0.9 * position, 1e-3) << value;
    }
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const Int8 entries = transfer.entries(Float8{-kInfinity, -1, -0.0f, 0, 1e-38f, 11, 1e30f, kInfinity});
    const int expected[] = {0, 0, 0, 0, 0, 1023, 1023, 1023};
    for (int i = 0; i < 8; ++i)
        EXPECT_EQ(entries[i], expected[i]) << i;
    EXPECT_GE(transfer.entries(broadcast8(std::numeric_limits<float>::quiet_NaN()))[0], 0);
    params.opacity = {{0.5, 0}, {1, 0.9}};
    EXPECT_FALSE(TransferFunction(params).contributes(-5, 0.3f));
    EXPECT_TRUE(TransferFunction(params).contributes(-5, 0.33f));
    // The widest range that there may be.
    params.range = {{ScalarAxis::kLeastValue, ScalarAxis::kMostValue}};
    const TransferFunction wide(params);
    EXPECT_NEAR(displayFromLinear(wide.table()[wide.entries(broadcast8(1))[0]].red), 0.5, 1e-3);
}

TEST(TransferFunction, ScalesOfColourAndOpacityAreTwo)
{
    TransferParams params = grayBetween({{0, 0}, {1, 0.9}}, 1, 100);
    params.opacityRange = {{-5, 5}};
    params.colorScale = ValueScale::kLogarithmic;
    const TransferFunction transfer(params);
    EXPECT_EQ(transfer.opacityAxis().scale, ValueScale::kLinear);
    EXPECT_NEAR(displayFromLinear(transfer.table()[transfer.colorEntries(broadcast8(10))[0]].red), 0.5, 1e-3);
    EXPECT_NEAR(-std::expm1(-transfer.table()[transfer.entries(broadcast8(0))[0]].extinction), 0.45, 1e-3);
    params.opacityRange.reset();
    EXPECT_EQ(TransferFunction(params).opacityAxis().scale, ValueScale::kLogarithmic);
}

TEST(TransferFunction, ALogarithmicRangeBeginsAboveZero)
{
    for (const double low : {-1.0, 0.0, 1e-31}) {
        TransferParams params{.range = {{low, 1}}, .colorScale = ValueScale::kLogarithmic};
        EXPECT_THROW(params.validate(), ParameterError) << low;
        params = {.opacityRange = {{low, 1}}, .opacityScale = ValueScale::kLogarithmic};
        EXPECT_THROW(params.validate(), ParameterError) << low;
        params = grayBetween({{0, 1}}, low, 1);
        params.opacityScale = ValueScale::kLogarithmic;
        EXPECT_THROW((void)TransferFunction(params), ParameterError) << low;
    }
    EXPECT_EQ(valueOf<ValueScale>("log"), ValueScale::kLogarithmic);
    for (const char* bad : {"", "Log", "logarithmic", "linear "})
        EXPECT_THROW((void)valueOf<ValueScale>(bad), ParameterError) << bad;
}

/// CIE lightness, 0 to 100.
double lightness(const glm::dvec3& linear)
{
    return 116 * std::cbrt(glm::dot(linear, glm::dvec3(0.2126, 0.7152, 0.0722))) - 16;
}

TEST(ColorMaps, DefaultGetsBrighterForEveryEye)
{
    // The identity, and eyes without green and without red cones (Machado, Oliveira & Fernandes 2009), by rows.
    const glm::dmat3 eyes[] = {
        glm::dmat3(1),
        glm::dmat3(0.367322, 0.860646, -0.227968, 0.280085, 0.672501, 0.047413, -0.011820, 0.042940, 0.968881),
        glm::dmat3(0.152286, 1.052583, -0.204868, 0.114503, 0.786281, 0.099216, -0.003882, -0.048116, 1.051998)};
    const auto leastRise = [&](std::string_view name, const glm::dmat3& eye) {
        double least = 100;
        for (int i = 0; i < 16; ++i) {
            const auto light = [&](int at) { return lightness(linearFromDisplay(colorMap(name, at / 16.0)) * eye); };
            least = std::min(least, light(i + 1) - light(i));
        }
        return least;
    };
    for (const glm::dmat3& eye : eyes)
        EXPECT_GT(leastRise(TransferParams{}.colorMap, eye), 2);
    EXPECT_GT(lightness(linearFromDisplay(colorMap(TransferParams{}.colorMap, 0))), 25); // not lost on a dark ground
    EXPECT_LT(leastRise("turbo", eyes[0]), -5);                                          // what the test is for
}

} // namespace
} // namespace vdblic
