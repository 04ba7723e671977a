#pragma once

#include "vdblic/lic/pathline_params.h"

#include <cstddef>

namespace vdblic {

enum class ScatterMethod { kAuflic, kUflic };

/// How values are scattered along pathlines.
///
/// With substeps every voxel still has one seed a frame, released in a substep that differs from tile to tile, and a
/// value lives as many frames as without: the work of a step and the memory do not grow with their number.
struct ScatterParams {
    ScatterMethod method = ScatterMethod::kAuflic;
    int lifeSpan = 4; ///< frames over which a seed scatters its value; with history the value fades at that pace
    int substeps = 1; ///< time steps from a frame to the next
    float releaseWindow = 0.25f; ///< AUFLIC: part of a frame, from its start, in which a seed may be released
    /// AUFLIC: a blocked pathline ends at once. Its values go to the pathline that began the step in the same voxel, if
    /// there is one. Values fade with every frame (FadingHits), and a new pathline begins as if it had taken up its
    /// first seed's value in every frame before.
    /// Without history all is as in the paper: a blocked pathline scatters its values to the end of their life span, a
    /// new one carries its own seeds only.
    bool history = true;
    PathlineParams pathline;

    [[nodiscard]] bool keepsHistory() const { return method == ScatterMethod::kAuflic && history; }
    /// Words that a particle carries: one Generation for each frame of the life span, if its values expire one by one.
    [[nodiscard]] std::size_t generations() const
    {
        return method == ScatterMethod::kAuflic && !history ? std::size_t(lifeSpan) : 0;
    }
    void validate() const; ///< @throws ParameterError
};

} // namespace vdblic
