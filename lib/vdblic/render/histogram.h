#pragma once

#include "vdblic/render/look.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

namespace vdblic {

/// How often values of a quantity occur, between two bounds and outside them.
struct Histogram {
    static constexpr std::size_t kBins = 256;

    double low = 0, high = 1;
    std::array<std::uint64_t, kBins> counts{}; ///< bin i covers low + (high − low) · [i, i + 1) / kBins
    std::uint64_t below = 0, above = 0;        ///< a value of `high` itself is in the last bin

    void add(double value);
    /// Add the counts of one with the same bounds.
    void add(const Histogram& other);
    [[nodiscard]] std::uint64_t total() const; ///< those outside included
};

/// The histograms of texture and magnitude: what transfer functions are designed from (Liu & Moorhead 2004, Figure 4).
struct TextureHistograms {
    Histogram texture;   ///< from 0 to 1
    Histogram magnitude; ///< a quarter of the look's range further than that, yet not beyond 0 [world/s]

    /// Empty ones, with the bounds for a look.
    explicit TextureHistograms(const Look& look);
    /// Count every active voxel of a texture, with its magnitude; numbers that are not finite are left out.
    void add(const openvdb::FloatGrid& texture, const openvdb::FloatGrid& magnitude);
    void add(const TextureHistograms& other);
};

/// Histograms, and the look's colours and opacities at the magnitude histogram's bins, as JSON.
[[nodiscard]] std::string histogramJson(const TextureHistograms& histograms, const Look& look);

/// The histograms as a picture in PNG, the transfer function drawn over that of magnitude.
[[nodiscard]] std::string histogramPng(const TextureHistograms& histograms, const Look& look);

/// @throws ParameterError unless the file ends in .json or .png
void checkHistogramPath(const std::filesystem::path& path);

/// Write one of the two as the file's extension asks. @throws ParameterError, OutputError
void writeHistograms(const std::filesystem::path& path, const TextureHistograms& histograms, const Look& look);

} // namespace vdblic
