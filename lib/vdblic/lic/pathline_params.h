#pragma once

#include "vdblic/core/parameters.h"

namespace vdblic {

/// Integration and sampling of pathlines.
struct PathlineParams {
    float tolerance = 0.05f;    ///< largest estimated error of one integration step [voxels]
    float sampleSpacing = 0.5f; ///< distance between samples along the path [voxels]

    void validate() const; ///< @throws ParameterError
};
[[nodiscard]] Parameters parametersOf(PathlineParams& params);

} // namespace vdblic
