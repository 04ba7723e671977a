#include "vdblic/look/look_preset.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace vdblic {

std::vector<std::string> lookPresetNames()
{
    return {"flow", "vortex", "streaks", "paper", "ink", "smoke", "xray"};
}

std::string defaultLookName(bool isSparse)
{
    return isSparse ? "streaks" : "flow";
}

LookPreset lookPreset(std::string_view name)
{
    LookPreset preset{.name = std::string(name), .look = {}, .background = {}};
    LookParams& look = preset.look;
    if (name == "flow" || name == "vortex" || name == "streaks") {
        if (name == "vortex") preset.opacityBy = {"q", "vorticity"};
        if (name != "flow") {
            look.shadows = 0.4;
            look.occlusion = 0.8;
        }
        if (name == "streaks") look.opticalDepth = 2; // streaks are solid, and one sees between them
        look.halo = 0.3;
        look.depthCue = 0.25;
        look.shading.ambient = 0.55f;
    } else if (name == "paper") {
        // On a bright ground dark streaks stand out.
        look.transfer.colors = {{0, {0.95, 0.62, 0.13}},
                                {0.25, {0.90, 0.36, 0.20}},
                                {0.5, {0.74, 0.17, 0.38}},
                                {0.75, {0.40, 0.14, 0.56}},
                                {1, {0.09, 0.14, 0.50}}};
        look.opticalDepth = 8; // faint streaks on a bright ground are pale
        look.halo = 0.1;
        look.depthCue = 0.15;
        look.shadows = 0.3;
        look.exposure = 0.4;
        look.limbDarkening = 0.8;
        look.shading.ambient = 0.7f;
        look.shading.diffuse = 0.5f;
        preset.background = {.color = glm::dvec3(1), .alpha = 0, .top = glm::dvec3(0.9, 0.92, 0.945)};
    } else if (name == "ink") {
        look.transfer.colorMap = "ink";
        look.shading.model = ShadingModel::kLine;
        look.shading.ambient = 1;
        look.shading.diffuse = 0;
        look.shading.specular = 0;
        look.opticalDepth = 2;
        look.limbDarkening = 0;
        look.halo = 0.06;
        look.depthCue = 0.2;
        preset.background.color = {0.965, 0.95, 0.915};
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
