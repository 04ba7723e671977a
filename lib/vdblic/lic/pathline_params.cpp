#include "vdblic/lic/pathline_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

namespace vdblic {

Parameters parametersOf(PathlineParams& params)
{
    return {
        parameter({.key = "sample_spacing",
                   .text = "Distance of deposits on a pathline.",
                   .unit = "voxels",
                   .group = "Texture",
                   .limits = {0.05, 10},
                   .isExpert = true},
                  params.sampleSpacing),
        parameter({.key = "tolerance",
                   .text = "Largest error of an integration step.",
                   .unit = "voxels",
                   .group = "Texture",
                   .limits = {1e-4, 10},
                   .isExpert = true},
                  params.tolerance),
    };
}

void PathlineParams::validate() const
{
    PathlineParams copy = *this;
    checkLimits(parametersOf(copy));
}

} // namespace vdblic
