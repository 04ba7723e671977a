#pragma once

#include <array>
#include <cstddef>

namespace vdblic {

/// A range of displacements: how far the flow moves in a step [texture voxels]. The lower limit is excluded.
struct DisplacementClass {
    double from, to;
};
inline constexpr std::array<DisplacementClass, 4> kDisplacementClasses = {{{0.5, 2}, {2, 4}, {4, 8}, {8, 30}}};

/// A class of fewer points in a frame has no figures: noise would pass for a measurement.
inline constexpr std::size_t kLeastClassPoints = 500;

/// How clean a texture is where the displacement is of one class. A figure that cannot be computed is not-a-number.
struct Cleanness {
    std::size_t points = 0; ///< voxels at which it was measured
    double isolated;        ///< share of voxels beyond the range of their 26 neighbours by more than 0.05
    double line;            ///< mean of (w2 − w1) / (w2 + w1), w1 ≤ w2 ≤ w3: 1 for straight lines, 0 for grains
    double angle;           ///< median angle between the direction of w1 and the velocity [degrees]
    double deviation;       ///< standard deviation of the voxels
    double temporal;        ///< correlation of a voxel with the successor at the end of its pathline
    double samePlace;       ///< correlation of a voxel with the successor at the same place
};

/// One figure and its name in reports.
struct CleannessFigure {
    const char* name;
    double Cleanness::*value;
};
inline constexpr std::array<CleannessFigure, 6> kCleannessFigures = {{{"isolated", &Cleanness::isolated},
                                                                      {"line", &Cleanness::line},
                                                                      {"angle", &Cleanness::angle},
                                                                      {"deviation", &Cleanness::deviation},
                                                                      {"temporal", &Cleanness::temporal},
                                                                      {"same_place", &Cleanness::samePlace}}};

/// In the order of kDisplacementClasses.
using CleannessByClass = std::array<Cleanness, kDisplacementClasses.size()>;

} // namespace vdblic
