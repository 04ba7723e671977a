#include "vdblic/render/histogram.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/atomic_file.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <numeric>

namespace vdblic {
namespace {

// How far beyond the look's range magnitudes are counted, in shares of the range.
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
    magnitude.low = low >= 0 ? std::max(low - beyond, 0.0) : low - beyond;
    magnitude.high = high + beyond;
}

void TextureHistograms::add(const openvdb::FloatGrid& textures, const openvdb::FloatGrid& magnitudes)
{
    const auto speeds = magnitudes.getConstAccessor();
    for (auto value = textures.cbeginValueOn(); value; ++value) {
        openvdb::CoordBBox box;
        value.getBoundingBox(box); // of a voxel or a tile
        for (auto voxel = box.begin(); voxel; ++voxel) {
            const float speed = speeds.getValue(*voxel);
            if (!std::isfinite(*value) || !std::isfinite(speed)) continue;
            texture.add(double(*value));
            magnitude.add(double(speed));
        }
    }
}

void TextureHistograms::add(const TextureHistograms& other)
{
    texture.add(other.texture);
    magnitude.add(other.magnitude);
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
        {"magnitude", toJson(histograms.magnitude)},
        {"transferFunction", {{"range", transfer.range()}, {"colorMap", transfer.colorMapName()}, {"opacity", points}}},
    };
    return json.dump(1) + "\n";
}

void checkHistogramPath(const std::filesystem::path& path)
{
    if (path.extension() == ".json" || path.extension() == ".png") return;
    throw ParameterError(fmt::format("histogram '{}' must end in .json or .png", path.string()));
}

void writeHistograms(const std::filesystem::path& path, const TextureHistograms& histograms, const Look& look)
{
    checkHistogramPath(path);
    writeTextFile(path, path.extension() == ".json" ? histogramJson(histograms, look) : histogramPng(histograms, look));
}

} // namespace vdblic
