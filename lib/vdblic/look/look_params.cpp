#include "vdblic/look/look_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <cmath>

namespace vdblic {

void LookParams::validate() const
{
    transfer.validate();
    shading.validate();
    const auto share = [](const char* name, double value) {
        if (!(value >= 0 && value <= 1)) {
            throw ParameterError(fmt::format("{} {} must be between 0 and 1", name, value));
        }
    };
    share("texture strength", textureStrength);
    share("limb darkening", limbDarkening);
    share("depth cue", depthCue);
    share("strength of shadows", shadows);
    if (!(opticalDepth > 0) || !std::isfinite(opticalDepth)) {
        throw ParameterError(fmt::format("optical depth {} must be a number above 0", opticalDepth));
    }
    if (!(halo >= 0) || !std::isfinite(halo)) {
        throw ParameterError(fmt::format("halo strength {} must be a number not below 0", halo));
    }
}

} // namespace vdblic
