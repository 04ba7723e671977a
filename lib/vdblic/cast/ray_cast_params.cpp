#include "vdblic/cast/ray_cast_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

namespace vdblic {

Parameters parametersOf(RayCastParams& params)
{
    const Parameters own = {
        parameter("step", "Distance between samples of voxels. Opacity does not depend on it.", params.step,
                  {.unit = "voxels", .limits = {0.01, 100}}),
        parameter(
            "interpolation",
            "Of the texture between its voxels; by default cubic where a voxel covers more than three pixels, else "
            "linear.",
            params.interpolation, {.words = "HOW"}),
    };
    return joined({own, parametersOf(params.clip)});
}

void RayCastParams::validate() const
{
    RayCastParams copy = *this;
    checkLimits(parametersOf(copy));
    if (!(leastTransmittance >= 0 && leastTransmittance < 1)) {
        throw ParameterError(fmt::format("least transmittance {} must be at least 0 and below 1", leastTransmittance));
    }
    clip.validate();
}

} // namespace vdblic
