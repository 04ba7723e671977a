#include "vdblic/look/histogram.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/json_file.h"
#include "vdblic/io/output_pattern.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
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
    return {{"low", histogram.low},     {"high", histogram.high},   {"scale", nameOf(histogram.scale)},
            {"below", histogram.below}, {"above", histogram.above}, {"counts", histogram.counts}};
}

/// Bounds around a range of the look.
Histogram around(const ScalarAxis& axis)
{
    const double low = axis.value(-kBeyond);
    return {.low = axis.range[0] >= 0 ? std::max(low, 0.0) : low, .high = axis.value(1 + kBeyond), .scale = axis.scale};
}

nlohmann::json toJson(const Histogram& histogram, const std::string& name)
{
    nlohmann::json json = toJson(histogram);
    json["grid"] = name;
    return json;
}

} // namespace

void Histogram::add(double value)
{
    if (value < low) {
        ++below;
    } else if (value > high) {
        ++above;
    } else {
        ++counts[std::min(std::size_t(axis().position(value) * kBins), kBins - 1)];
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
    : color(around(look.transfer.colorAxis())), opacity(around(look.transfer.opacityAxis()))
{
}

void TextureHistograms::add(const openvdb::FloatGrid& textures, const openvdb::FloatGrid& colors,
                            const openvdb::FloatGrid& opacities)
{
    const auto colorValues = colors.getConstAccessor(), opacityValues = opacities.getConstAccessor();
    for (auto value = textures.cbeginValueOn(); value; ++value) {
        openvdb::CoordBBox box;
        value.getBoundingBox(box); // of a voxel or a tile
        for (auto voxel = box.begin(); voxel; ++voxel) {
            const float colored = colorValues.getValue(*voxel), opaque = opacityValues.getValue(*voxel);
            if (!std::isfinite(*value) || !std::isfinite(colored) || !std::isfinite(opaque)) continue;
            texture.add(double(*value));
            color.add(double(colored));
            opacity.add(double(opaque));
        }
    }
}

void TextureHistograms::add(const VolumeSamples& samples)
{
    const std::vector<float>& colors = samples.color.empty() ? samples.driver : samples.color;
    for (std::size_t i = 0; i < samples.texture.size(); ++i) {
        texture.add(double(samples.texture[i]));
        color.add(double(colors[i]));
        opacity.add(double(samples.driver[i]));
    }
}

void TextureHistograms::add(const TextureHistograms& other)
{
    texture.add(other.texture);
    color.add(other.color);
    opacity.add(other.opacity);
}

std::string histogramJson(const TextureHistograms& histograms, const Look& look, const ScalarNames& names)
{
    const TransferFunction& transfer = look.transfer;
    nlohmann::json points = nlohmann::json::array();
    for (const OpacityPoint& point : transfer.opacity())
        points.push_back({point.position, point.opacity});
    const nlohmann::json json = {
        {"voxels", histograms.texture.total()},
        {"texture", toJson(histograms.texture)},
        {"color", toJson(histograms.color, names.color)},
        {"opacity", toJson(histograms.opacity, names.opacity)},
        {"transferFunction",
         {{"range", transfer.range()},
          {"opacityRange", transfer.opacityRange()},
          {"colorScale", nameOf(transfer.colorAxis().scale)},
          {"opacityScale", nameOf(transfer.opacityAxis().scale)},
          {"colorMap", transfer.colorMapName()},
          {"opacity", points}}},
    };
    return jsonText(json, 1);
}

void checkHistogramPath(const std::filesystem::path& path)
{
    checkExtension(path, {".json", ".png"});
}

bool writeHistograms(const std::filesystem::path& path, const TextureHistograms& histograms, const Look& look,
                     const ScalarNames& names)
{
    checkHistogramPath(path);
    return writeReport(path, std::tolower(static_cast<unsigned char>(path.extension().string()[1])) == 'j'
                                 ? histogramJson(histograms, look, names)
                                 : histogramPng(histograms, look, names));
}

} // namespace vdblic
