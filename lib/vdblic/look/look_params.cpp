#include "vdblic/look/look_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <cmath>

namespace vdblic {

Parameters parametersOf(LookParams& params)
{
    const Parameters texture = {
        parameter("modulate", "How strongly the texture shows in opacity.", params.textureStrength,
                  {.group = "Colour and opacity", .limits = {0, 1}, .attribute = "textureStrength"}),
        parameter("limb_darkening", "How strongly the texture shows in colour: dark rims of streaks.",
                  params.limbDarkening, {.group = "Colour and opacity", .limits = {0, 1}}),
    };
    const Parameters light = {
        parameter("halo", "Strength of the gaps that streaks cut into what is behind them; 0: none.", params.halo,
                  {.group = "Light", .limits = {0, 1e9}}),
        parameter("shadows", "How dark it is where the volume lets no light through.", params.shadows,
                  {.group = "Light", .limits = {0, 1}}),
        parameter("depth_cue", "How far the most distant samples fade into the background.", params.depthCue,
                  {.group = "Light", .limits = {0, 1}}),
    };
    return joined({parametersOf(params.transfer), texture, parametersOf(params.shading), light});
}

void LookParams::validate() const
{
    transfer.validate();
    shading.validate();
    LookParams copy = *this;
    checkLimits(parametersOf(copy));
    if (!(opticalDepth > 0) || !std::isfinite(opticalDepth)) {
        throw ParameterError(fmt::format("optical depth {} must be a number above 0", opticalDepth));
    }
}

} // namespace vdblic
