#include "vdblic/lic/pathline_params.h"

#include <fmt/format.h>

namespace vdblic {

Parameters parametersOf(PathlineParams& params)
{
    return {
        parameter("sample_spacing", "Distance of deposits on a pathline.", params.sampleSpacing,
                  {.unit = "voxels", .limits = {0.05, 10}}),
        parameter("tolerance", "Largest error of an integration step.", params.tolerance,
                  {.unit = "voxels", .limits = {1e-4, 10}}),
    };
}

void PathlineParams::validate() const
{
    PathlineParams copy = *this;
    checkLimits(parametersOf(copy));
}

} // namespace vdblic
