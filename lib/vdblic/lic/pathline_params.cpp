#include "vdblic/lic/pathline_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

namespace vdblic {

void PathlineParams::validate() const
{
    if (!(tolerance >= 1e-4f && tolerance <= 10)) {
        throw ParameterError(fmt::format("tolerance {} must lie between 0.0001 and 10 voxels", tolerance));
    }
    if (!(sampleSpacing >= 0.05f && sampleSpacing <= 10)) {
        throw ParameterError(fmt::format("sample spacing {} must lie between 0.05 and 10 voxels", sampleSpacing));
    }
}

} // namespace vdblic
