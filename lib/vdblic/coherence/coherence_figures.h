#pragma once

#include "vdblic/coherence/cleanness_figures.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace vdblic {

/// The longest lag of an autocorrelation [voxels of the velocity].
inline constexpr double kLongestLag = 16;

/// The lags of an autocorrelation, ascending [voxels of the velocity].
///
/// Up to 16 voxels of the texture they are half a texture voxel apart, so that they resolve the width of streaks. From
/// there to kLongestLag they are half a voxel of the velocity apart. Every multiple of half a voxel of the velocity is
/// among them, so textures of one flow can be compared lag by lag.
/// @param factors of the texture's refinement; the texture voxel is the smallest along any axis
[[nodiscard]] std::vector<double> coherenceLags(const std::array<int, 3>& factors);

/// The figures of one texture. A figure that cannot be computed is not-a-number.
struct CoherenceFigures {
    double temporal;  ///< correlation of the texture with its successor at the ends of pathlines
    double samePlace; ///< correlation of the texture with its successor at the same position
    double gain;      ///< temporal − samePlace

    std::vector<double> along, across; ///< autocorrelation by lag along the flow, and perpendicular to it
    double alongLength; ///< first lag where it falls under 1/e [voxels of the velocity], kLongestLag at most
    double acrossLength;
    double lengthRatio; ///< alongLength / acrossLength

    double deviation; ///< standard deviation over all voxels
    double saturated; ///< share of all voxels that eight bits would show as black or white
};

/// A figure that is one number, and its name in reports.
struct NamedFigure {
    const char* name;
    double CoherenceFigures::*value;
};
inline constexpr std::array<NamedFigure, 8> kNamedFigures = {{{"temporal", &CoherenceFigures::temporal},
                                                              {"same_place", &CoherenceFigures::samePlace},
                                                              {"gain", &CoherenceFigures::gain},
                                                              {"along_length", &CoherenceFigures::alongLength},
                                                              {"across_length", &CoherenceFigures::acrossLength},
                                                              {"length_ratio", &CoherenceFigures::lengthRatio},
                                                              {"deviation", &CoherenceFigures::deviation},
                                                              {"saturated", &CoherenceFigures::saturated}}};

/// Statistics of the grid `hits` of a texture file.
struct HitFigures {
    double mean = 0;      ///< hits per voxel
    double zeroShare = 0; ///< share of voxels without hits
};

/// The figures of one frame.
struct FrameCoherence {
    std::int64_t frame = 1;
    std::size_t points = 0;         ///< of the spatial figures at the shortest lag
    std::size_t temporalPoints = 0; ///< 0 if there is no successor
    CoherenceFigures raw, smoothed; ///< of the texture as it is, and after the 3³ binomial filter
    CleannessByClass byDisplacement;
    std::optional<HitFigures> hits;
};

} // namespace vdblic
