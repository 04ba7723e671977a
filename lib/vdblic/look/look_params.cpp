#include "vdblic/look/look_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <cmath>

namespace vdblic {

Parameters parametersOf(LookParams& params)
{
    const Parameters texture = {
        parameter({.key = "modulate",
                   .text = "How strongly the texture shows in opacity.",
                   .group = "Colour and opacity",
                   .limits = {0, 1},
                   .attribute = "textureStrength"},
                  params.textureStrength),
        parameter({.key = "limb_darkening",
                   .text = "How strongly the texture shows in colour: dark rims of streaks.",
                   .group = "Colour and opacity",
                   .limits = {0, 1}},
                  params.limbDarkening),
    };
    const Parameters light = {
        parameter({.key = "halo",
                   .text = "Strength of the gaps that streaks cut into what is behind them; 0: none.",
                   .group = "Light",
                   .limits = {0, 1e9}},
                  params.halo),
        parameter({.key = "shadows",
                   .text = "How dark it is where the volume lets no light through.",
                   .group = "Light",
                   .limits = {0, 1}},
                  params.shadows),
        parameter({.key = "depth_cue",
                   .text = "How far the most distant samples fade into the background.",
                   .group = "Light",
                   .limits = {0, 1}},
                  params.depthCue),
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
