#pragma once

#include "vdblic/look/look.h"

#include <openvdb/openvdb.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace vdblic {

/// How often values occur, between two bounds and outside them.
struct Histogram {
    static constexpr std::size_t kBins = 256;

    double low = 0, high = 1;
    ValueScale scale = ValueScale::kLinear;
    std::array<std::uint64_t, kBins> counts{}; ///< bin i covers positions [i, i + 1) / kBins of the axis
    std::uint64_t below = 0, above = 0;        ///< a value equal to `high` is in the last bin

    [[nodiscard]] ScalarAxis axis() const { return {{low, high}, scale}; }
    void add(double value);
    /// Add the counts of a histogram with the same bounds.
    void add(const Histogram& other);
    [[nodiscard]] std::uint64_t total() const; ///< values outside the bounds included
};

/// The histograms of texture and scalars, for the design of transfer functions (Liu & Moorhead 2004, Figure 4).
struct TextureHistograms {
    Histogram texture; ///< from 0 to 1
    /// Of the scalars: the look's ranges and a quarter on each side, but not beyond 0, on the look's scales.
    Histogram color, opacity;

    /// Empty histograms with the bounds for a look.
    explicit TextureHistograms(const Look& look);
    /// Count every active voxel of a texture and its scalars; voxels with a number that is not finite are left out.
    void add(const openvdb::FloatGrid& texture, const openvdb::FloatGrid& color, const openvdb::FloatGrid& opacity);
    /// Count samples. @param samples all finite
    void add(const VolumeSamples& samples);
    void add(const TextureHistograms& other);
};

/// Names of the grids of a histogram.
struct ScalarNames {
    std::string color, opacity; ///< equal if one scalar does both
};

/// Histograms, and the look's curves, as JSON.
[[nodiscard]] std::string histogramJson(const TextureHistograms& histograms, const Look& look,
                                        const ScalarNames& names);

/// The histograms as a picture in PNG, the transfer function drawn over the scalars' histograms. Equal input gives
/// equal bytes.
[[nodiscard]] std::string histogramPng(const TextureHistograms& histograms, const Look& look, const ScalarNames& names);

/// @throws ParameterError unless the file ends in .json or .png
void checkHistogramPath(const std::filesystem::path& path);

/// Write JSON or PNG, by the file's extension, as writeReport() does. @throws ParameterError, OutputError
bool writeHistograms(const std::filesystem::path& path, const TextureHistograms& histograms, const Look& look,
                     const ScalarNames& names);

} // namespace vdblic
