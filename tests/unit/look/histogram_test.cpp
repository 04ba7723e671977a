#include "vdblic/look/histogram.h"

#include "cast/test_scene.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <png.h>

#include <cmath>
#include <limits>

namespace vdblic {
namespace {

using openvdb::Coord;

const ScalarNames kScalars{"magnitude", "magnitude"};

TEST(Histogram, CountsWhatIsInEachBin)
{
    Histogram histogram{.low = 1, .high = 3};
    for (const double value : {1.0, 1.001, 2.0, 2.999, 3.0})
        histogram.add(value);
    histogram.add(0.99);
    histogram.add(3.01);
    histogram.add(-1e300);
    EXPECT_EQ(histogram.counts[0], 2u);
    EXPECT_EQ(histogram.counts[Histogram::kBins / 2], 1u);
    EXPECT_EQ(histogram.counts[Histogram::kBins - 1], 2u);
    EXPECT_EQ(histogram.below, 2u);
    EXPECT_EQ(histogram.above, 1u);
    EXPECT_EQ(histogram.total(), 8u);
}

TEST(Histogram, BinsOfALogarithmicScaleAreEvenInPowers)
{
    Histogram histogram{.low = 0.25, .high = 4, .scale = ValueScale::kLogarithmic};
    for (const double value : {0.26, 1.01, 2.02, 4.0, 0.2, 0.0, -3.0, 5.0})
        histogram.add(value);
    for (const std::size_t bin : {std::size_t(3), Histogram::kBins / 2, Histogram::kBins * 3 / 4, Histogram::kBins - 1})
        EXPECT_EQ(histogram.counts[bin] + histogram.counts[bin - 1] + histogram.counts[bin == 255 ? 0 : bin + 1], 1u)
            << bin;
    EXPECT_EQ(histogram.below, 3u);
    EXPECT_EQ(histogram.above, 1u);
    // Around a look's range by a quarter of its powers.
    TransferParams params{.opacity = {{0, 1}}, .range = {{0.01, 100}}, .colorScale = ValueScale::kLogarithmic};
    const TextureHistograms histograms(Look{TransferFunction(params), {}, {}});
    EXPECT_NEAR(histograms.color.low, 0.001, 1e-9);
    EXPECT_NEAR(histograms.color.high, 1000, 1e-3);
}

TEST(Histogram, OfAVolumeHoldsEveryActiveVoxelThatIsANumber)
{
    const auto texture = boxGrid("density", boxOf(20, 10, 5), [](const Coord& c) { return float(c.x()) / 20; });
    const auto driver = boxGrid("magnitude", boxOf(20, 10, 5), [](const Coord& c) { return float(c.y()) / 10; });
    texture->tree().setValueOn(Coord(3, 3, 3), std::numeric_limits<float>::quiet_NaN());
    driver->tree().setValueOn(Coord(4, 4, 4), std::numeric_limits<float>::infinity());
    texture->fill(openvdb::CoordBBox(Coord(64), Coord(71)), 0.5f, true); // a tile
    driver->fill(openvdb::CoordBBox(Coord(64), Coord(71)), 0.25f, true);
    TextureHistograms histograms(fullLook()); // driver from 0 to 1
    histograms.add(*texture, *driver, *driver);
    EXPECT_EQ(histograms.texture.total(), 1000u - 2 + 512);
    EXPECT_EQ(histograms.texture.counts[0], 50u);
    EXPECT_EQ(histograms.texture.counts[Histogram::kBins / 2], 50u + 512);
    EXPECT_EQ(histograms.color.low, 0);
    EXPECT_EQ(histograms.color.high, 1.25);

    TextureHistograms sum(fullLook());
    sum.add(histograms);
    sum.add(histograms);
    EXPECT_EQ(sum.color.total(), 2 * histograms.color.total());
}

TEST(Histogram, JsonHoldsCountsAndTransferFunction)
{
    TextureHistograms histograms(fullLook());
    const auto grid = boxGrid("density", boxOf(9, 9, 9), scattered);
    histograms.add(*grid, *grid, *grid);
    const auto json = nlohmann::json::parse(histogramJson(histograms, fullLook(), kScalars));
    EXPECT_EQ(json["voxels"], 729);
    EXPECT_EQ(json["texture"]["counts"].size(), Histogram::kBins);
    std::uint64_t sum = 0;
    for (const auto& count : json["color"]["counts"])
        sum += count.get<std::uint64_t>();
    EXPECT_EQ(sum, 729u);
    EXPECT_EQ(json["opacity"]["grid"], "magnitude");
    EXPECT_EQ(json["transferFunction"]["opacity"][2][0], 0.6);
}

TEST(Histogram, TwoScalarsHavePanelsOfTheirOwn)
{
    const auto grid = boxGrid("density", boxOf(9, 9, 9), scattered);
    const auto other = boxGrid("q", boxOf(9, 9, 9), [](const Coord& c) { return 10 * scattered(c) - 5; });
    const Look look{TransferFunction({.opacity = {{0, 0.5}}, .range = {{0, 1}}, .opacityRange = {{-4, 4}}}), {}, {}};
    TextureHistograms histograms(look);
    histograms.add(*grid, *grid, *other);
    EXPECT_EQ(histograms.color.high, 1.25);
    EXPECT_EQ(histograms.opacity.low, -6);
    EXPECT_EQ(histograms.opacity.total(), 729u);
    const std::string two = histogramPng(histograms, look, {"magnitude", "q"});
    const std::string one = histogramPng(histograms, look, kScalars);
    const auto width = [](const std::string& png) {
        return int((unsigned char)png[18]) * 256 + (unsigned char)png[19];
    };
    EXPECT_GT(width(two), width(one) + 500);
}

TEST(Histogram, EqualCountsGiveEqualPictures)
{
    TextureHistograms histograms(fullLook());
    const auto grid = boxGrid("density", boxOf(9, 9, 9), scattered);
    histograms.add(*grid, *grid, *grid);
    const std::string once = histogramPng(histograms, fullLook(), kScalars);
    EXPECT_EQ(histogramPng(histograms, fullLook(), kScalars), once);
    histograms.texture.add(0.5);
    EXPECT_NE(histogramPng(histograms, fullLook(), kScalars), once);
}

TEST(Histogram, PictureShowsBarsWhereThereAreCounts)
{
    // All textures are at one value, so one bar stands in an empty plot.
    TextureHistograms histograms(fullLook());
    const auto grid = boxGrid("density", boxOf(9, 9, 9), [](const Coord&) { return 0.25f; });
    histograms.add(*grid, *grid, *grid);
    const std::string bytes = histogramPng(histograms, fullLook(), kScalars);
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    ASSERT_TRUE(png_image_begin_read_from_memory(&png, bytes.data(), bytes.size())) << png.message;
    std::vector<png_byte> pixels(PNG_IMAGE_SIZE(png));
    ASSERT_TRUE(png_image_finish_read(&png, nullptr, pixels.data(), 0, nullptr)) << png.message;
    // Halfway up the left panel, which reaches from x = 40 to 552.
    const auto dark = [&](int x) { return pixels[(std::size_t(220) * png.width + unsigned(x)) * 3] < 200; };
    EXPECT_TRUE(dark(40 + 512 / 4 + 1));
    EXPECT_FALSE(dark(40 + 512 / 4 - 3));
    EXPECT_FALSE(dark(40 + 512 / 4 + 5));
    EXPECT_FALSE(dark(500));
    // The right panel, from 630 to 1142: nothing between the bar and the curve of the opacity.
    EXPECT_TRUE(dark(630 + 512 / 5 + 1));
    for (int x = 630 + 512 / 5 + 5; x < 910; ++x)
        EXPECT_FALSE(dark(x)) << x;
}

} // namespace
} // namespace vdblic
