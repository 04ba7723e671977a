#include "vdblic/cast/ray_cast_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

namespace vdblic {

void RayCastParams::validate() const
{
    if (!(step >= 0.01 && step <= 100)) {
        throw ParameterError(fmt::format("step {} must be between 0.01 and 100 voxels", step));
    }
    if (!(leastTransmittance >= 0 && leastTransmittance < 1)) {
        throw ParameterError(fmt::format("least transmittance {} must be at least 0 and below 1", leastTransmittance));
    }
    clip.validate();
}

} // namespace vdblic
