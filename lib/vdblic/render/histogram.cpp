#include "vdblic/render/histogram.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/output_pattern.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numeric>
#include <string>

namespace vdblic {
namespace {

// Margin on each side of the look's range, in shares of the range.
constexpr double kBeyond = 0.25;

nlohmann::json toJson(const Histogram& histogram)
{
    return {{"low", histogram.low},
            {"high", histogram.high},
            {"below", histogram.below},
            {"above", histogram.above},
            {"counts", histogram.counts}};
}

} // namespace

void Histogram::add(double value)
{
    if (value < low) {
        ++below;
    } else if (value > high) {
        ++above;
    } else {
        ++counts[std::min(std::size_t((value - low) / (high - low) * kBins), kBins - 1)];
    }
}

void Histogram::add(const Histogram& other)
{
    for (std::size_t i = 0; i < kBins; ++i)
        counts[i] += other.counts[i];
    below += other.below;
    above += other.above;
}

std::uint64_t Histogram::total() const
{
    return std::accumulate(counts.begin(), counts.end(), below + above);
}

TextureHistograms::TextureHistograms(const Look& look)
{
    const auto [low, high] = look.transfer.range();
    const double beyond = kBeyond * (high - low);
    driver.low = low >= 0 ? std::max(low - beyond, 0.0) : low - beyond;
    driver.high = high + beyond;
}

void TextureHistograms::add(const openvdb::FloatGrid& textures, const openvdb::FloatGrid& drivers)
{
    const auto speeds = drivers.getConstAccessor();
    for (auto value = textures.cbeginValueOn(); value; ++value) {
        openvdb::CoordBBox box;
        value.getBoundingBox(box); // of a voxel or a tile
        for (auto voxel = box.begin(); voxel; ++voxel) {
            const float speed = speeds.getValue(*voxel);
            if (!std::isfinite(*value) || !std::isfinite(speed)) continue;
            texture.add(double(*value));
            driver.add(double(speed));
        }
    }
}

void TextureHistograms::add(const TextureHistograms& other)
{
    texture.add(other.texture);
    driver.add(other.driver);
}

std::string histogramJson(const TextureHistograms& histograms, const Look& look)
{
    const TransferFunction& transfer = look.transfer;
    nlohmann::json points = nlohmann::json::array();
    for (const OpacityPoint& point : transfer.opacity())
        points.push_back({point.position, point.opacity});
    const nlohmann::json json = {
        {"voxels", histograms.texture.total()},
        {"texture", toJson(histograms.texture)},
        {"magnitude", toJson(histograms.driver)},
        {"transferFunction", {{"range", transfer.range()}, {"colorMap", transfer.colorMapName()}, {"opacity", points}}},
    };
    return json.dump(1) + "\n";
}

void checkHistogramPath(const std::filesystem::path& path)
{
    checkExtension(path, {".json", ".png"});
}

bool writeHistograms(const std::filesystem::path& path, const TextureHistograms& histograms, const Look& look)
{
    checkHistogramPath(path);
    return writeReport(path, std::tolower(static_cast<unsigned char>(path.extension().string()[1])) == 'j'
                                 ? histogramJson(histograms, look)
                                 : histogramPng(histograms, look));
}

} // namespace vdblic
