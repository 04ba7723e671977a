#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace vdblic {

/// The figures of one sparse texture, against its velocity and its successor. A figure that cannot be computed is
/// not-a-number.
struct SparseFigures {
    double held;      ///< share of the texture voxels of the velocity's domain that are active
    double rising;    ///< share of visible voxels whose value rises downstream: 1 shows the direction, ½ does not
    double temporal;  ///< correlation of visible voxels with the successor at their pathlines' ends
    double samePlace; ///< correlation with the successor at the same position
    double
        vanishing; ///< share of visible voxels that the successor has neither there nor where the flow carries them to
    double appearing;   ///< share of the successor's visible voxels that vanish against time
    double lowApart;    ///< 1st percentile of the distance of a head to the next one [spacings]; 1 where none is nearer
    double medianApart; ///< median of this distance
};

/// A figure of a sparse texture, and its name in reports.
struct NamedSparseFigure {
    const char* name;
    double SparseFigures::*value;
};
inline constexpr std::array<NamedSparseFigure, 8> kSparseFigures = {{{"held", &SparseFigures::held},
                                                                     {"rising", &SparseFigures::rising},
                                                                     {"temporal", &SparseFigures::temporal},
                                                                     {"same_place", &SparseFigures::samePlace},
                                                                     {"vanishing", &SparseFigures::vanishing},
                                                                     {"appearing", &SparseFigures::appearing},
                                                                     {"low_apart", &SparseFigures::lowApart},
                                                                     {"median_apart", &SparseFigures::medianApart}}};

/// The figures of one frame of a sparse texture.
struct SparseCoherence {
    std::int64_t frame = 1;
    std::size_t points = 0; ///< sampled visible voxels of moving fluid
    std::size_t heads = 0;  ///< of streaks
    SparseFigures figures;
};

} // namespace vdblic
