#pragma once

#include "vdblic/lic/pathline_params.h"

namespace vdblic {

enum class ScatterMethod { kAuflic, kUflic };

/// How values are scattered along pathlines.
///
/// With substeps a value lives as many frames as without, and the work of a step does not grow with their number.
/// AUFLIC counts the values of a frame's substeps together and forgets them together. A particle's frames begin at a
/// substep of its own, so that in every step the same share of values is forgotten. UFLIC releases a voxel's seed in
/// one of a frame's substeps, which differs from voxel to voxel.
struct ScatterParams {
    ScatterMethod method = ScatterMethod::kAuflic;
    int lifeSpan = 4;            ///< frames over which a seed scatters its value
    int substeps = 1;            ///< time steps from a frame to the next
    float releaseWindow = 0.25f; ///< AUFLIC: the part of a step, from its start, in which a seed may be released
    /// AUFLIC: a blocked pathline ends at once. Its values go to the pathline that began the step in the same voxel, if
    /// there is one. A new pathline starts with the values that a pathline through its voxel would carry.
    /// Without history both are as in the paper: a blocked pathline scatters its values to the end of their life span,
    /// a new one carries its own seeds only.
    bool history = true;
    PathlineParams pathline;

    static constexpr int kMaxSubsteps = 64; // a Generation counts 255 values

    void validate() const; ///< @throws ParameterError
};

} // namespace vdblic
