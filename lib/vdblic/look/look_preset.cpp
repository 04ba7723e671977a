#include "vdblic/look/look_preset.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace vdblic {

std::vector<std::string> lookPresetNames()
{
    return {"flow", "vortex", "streaks", "ink", "smoke", "xray"};
}

LookPreset lookPreset(std::string_view name)
{
    LookPreset preset{{}, {0.04, 0.05, 0.07}};
    LookParams& look = preset.look;
    if (name == "flow" || name == "vortex" || name == "streaks") {
        if (name == "vortex") preset.opacityBy = {"q", "vorticity"};
        if (name != "flow") look.shadows = 0.6;
        if (name == "streaks") look.opticalDepth = 1.2; // between streaks one sees what is behind them
        look.halo = 0.3;
        look.depthCue = 0.25;
        look.shading.ambient = 0.55f;
    } else if (name == "ink") {
        look.transfer.colorMap = "ink";
        look.shading.model = ShadingModel::kLine;
        look.shading.ambient = 1;
        look.shading.diffuse = 0;
        look.shading.specular = 0;
        look.opticalDepth = 8;
        look.limbDarkening = 0;
        look.halo = 0.06;
        look.depthCue = 0.2;
        preset.background = {0.965, 0.95, 0.915};
    } else if (name == "smoke") {
        look.transfer.colorMap = "gray";
        look.transfer.colors = {{0, {0.55, 0.58, 0.62}}, {1, {0.97, 0.96, 0.94}}};
        look.textureStrength = 0.97;
        look.limbDarkening = 0.9;
        look.opticalDepth = 2;
        look.shading.ambient = 0.25f;
        look.shading.diffuse = 0.55f;
        look.shading.specular = 0;
        look.shading.lights = {{{-0.5, -0.4, 0.8}, 0.8}};
    } else if (name == "xray") {
        look.transfer.colorMap = "ice";
        look.shading.model = ShadingModel::kNone;
        look.opticalDepth = 0.6;
        look.limbDarkening = 0.5;
    } else {
        throw ParameterError(fmt::format("no look '{}'; choose one of {}", name, fmt::join(lookPresetNames(), ", ")));
    }
    return preset;
}

} // namespace vdblic
