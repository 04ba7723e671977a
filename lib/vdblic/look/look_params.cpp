#include "vdblic/look/look_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <cmath>

namespace vdblic {
namespace {

constexpr double kMostStops = 20;

} // namespace

Parameters parametersOf(LookParams& params)
{
    const Parameters texture = {
        parameter("modulate", "How strongly the texture shows in opacity.", params.textureStrength, {.limits = {0, 1}}),
        parameter("limb_darkening", "How strongly the texture shows in colour: dark rims of streaks.",
                  params.limbDarkening, {.limits = {0, 1}}),
    };
    const Parameters light = {
        parameter("halo", "Strength of the gaps that streaks cut into what is behind them; 0: none.", params.halo,
                  {.limits = {0, 1e9}}),
        parameter("shadows", "How dark it is where the volume lets no light through.", params.shadows,
                  {.limits = {0, 1}}),
        parameter("occlusion", "How much darker than the rest it is where the volume is close all around.",
                  params.occlusion, {.limits = {0, 1}}),
        parameter("depth_cue", "How far the most distant samples fade into the background.", params.depthCue,
                  {.limits = {0, 1}}),
        parameter("exposure",
                  "Stops that the picture is brighter than lit; one doubles the light. By default two thirds of what "
                  "is seen are "
                  "about as bright as their colours in the colour bar, or brighter.",
                  params.exposure, {.unit = "stops", .limits = {-kMostStops, kMostStops}}),
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
