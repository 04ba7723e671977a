#pragma once

#include "vdblic/lic/pathline_params.h"

namespace vdblic {

enum class ScatterMethod { kAuflic, kUflic };

/// How values are scattered along pathlines.
struct ScatterParams {
    ScatterMethod method = ScatterMethod::kAuflic;
    int lifeSpan = 4;            ///< time steps over which a seed scatters its value
    float releaseWindow = 0.25f; ///< AUFLIC: the part of a step, from its start, in which a seed may be released
    /// AUFLIC: a blocked pathline ends at once. Its values go to the pathline that began the step in the same voxel, if
    /// there is one. A new pathline starts with the values that a pathline through its voxel would carry.
    /// Without history both are as in the paper: a blocked pathline scatters its values to the end of their life span,
    /// a new one carries its own seeds only.
    bool history = true;
    PathlineParams pathline;

    void validate() const; ///< @throws ParameterError
};

} // namespace vdblic
