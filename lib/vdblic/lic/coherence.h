#pragma once

#include "vdblic/lic/estimate.h"
#include "vdblic/lic/flow_sequence.h"
#include "vdblic/lic/pathline.h"
#include "vdblic/lic/smoothed_texture.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdblic {

/// The lags of an autocorrelation: kLagSpacing, 2 kLagSpacing, ... of arc length [voxels].
inline constexpr float kLagSpacing = 0.5f;
inline constexpr int kLagCount = 32;
inline constexpr double kLongestLag = double(kLagSpacing) * kLagCount;

/// Where a texture is looked at.
struct CoherenceParams {
    int samples = 100'000;    ///< points a frame, at random places of the texture's voxels; those that count are fewer
    float leastMotion = 0.5f; ///< a point counts where the flow moves at least this far [voxels per step]
    PathlineParams pathline;

    void validate() const; ///< @throws ParameterError
};

/// What is measured of one texture. A figure that could not be had is not-a-number.
struct CoherenceFigures {
    double temporal;  ///< correlation of the texture with its successor at the place the flow carries it to
    double samePlace; ///< correlation with the successor at the same place
    double gain;      ///< temporal − samePlace

    std::array<double, kLagCount> along, across; ///< autocorrelation by lag along the flow, and perpendicular to it
    double alongLength;                          ///< first lag where it falls under 1/e [voxels], kLongestLag at most
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

/// What a grid `hits` of a texture file says.
struct HitFigures {
    double mean = 0;      ///< values a voxel was hit by
    double zeroShare = 0; ///< share of voxels without any
};

/// What is measured of one frame.
struct FrameCoherence {
    std::int64_t frame = 1;
    std::size_t points = 0;         ///< of the spatial figures at the shortest lag
    std::size_t temporalPoints = 0; ///< 0 where there is no successor
    CoherenceFigures raw, smoothed; ///< of the texture as it is, and after the 3³ binomial filter
    std::optional<HitFigures> hits;
};

/// Measure a texture against its successor and the velocity between them.
///
/// Points are chosen by a hash of their number and the frame, uniformly over the texture's voxels and inside them. A
/// point counts where the eight voxels around have values and the flow moves by params.leastMotion. The temporal
/// figures take the points at which the same holds of the successor, at the same place and where advancePaths() leads
/// to. The spatial figures go from each point down the streamline of the velocity at the step's start, and in a
/// direction perpendicular to it that is chosen by the hash; a point counts for the lags at which it is inside.
/// All correlations are Pearson's, of trilinearly interpolated values.
///
/// @param next  the successor; null if there is none
/// @param field velocity over the step
/// Computed in parallel; the result is bit-identical for any number of threads. @throws ParameterError
[[nodiscard]] FrameCoherence measureCoherence(const SmoothedTexture& texture, const SmoothedTexture* next,
                                              const VelocityField& field, const CoherenceParams& params,
                                              std::int64_t frame);

/// Means over frames of the figures of one texture, raw or smoothed.
struct MeanFigures {
    std::array<Estimate, kNamedFigures.size()> figures; ///< in the order of kNamedFigures
    std::array<double, kLagCount> along, across;
};

struct SequenceCoherence {
    std::vector<FrameCoherence> frames;
    MeanFigures raw, smoothed;
};

/// What to measure, and where the results go.
struct SequenceCoherenceParams {
    FlowSequenceParams flow;
    std::string texture; ///< file or pattern; frames are matched by number
    std::string textureName = "density";
    CoherenceParams coherence;
    std::string json; ///< file for the figures; empty for none
    std::string plot; ///< SVG file for the autocorrelations; empty for none

    void validate() const; ///< @throws ParameterError
};

/// Measure every frame of a texture sequence and report each as it is known.
///
/// Frames come after each other as they are selected; the last one has no successor and no temporal figures.
/// @throws ParameterError; InputError if a frame is missing on one side or the transforms differ; OutputError
SequenceCoherence coherenceOfSequence(const SequenceCoherenceParams& params, Reporter& reporter);

} // namespace vdblic
