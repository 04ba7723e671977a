#include "vdblic/look/shading.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace vdblic {
namespace {

constexpr std::string_view kModelNames[] = {"phong", "lines", "none"};

} // namespace

ShadingModel shadingModel(std::string_view name)
{
    const auto* found = std::find(std::begin(kModelNames), std::end(kModelNames), name);
    if (found == std::end(kModelNames)) {
        throw ParameterError(fmt::format("no shading '{}'; choose one of phong, lines, none", name));
    }
    return ShadingModel(found - std::begin(kModelNames));
}

std::string_view shadingModelName(ShadingModel model)
{
    return kModelNames[int(model)];
}

void Shading::validate() const
{
    for (const float value : {ambient, diffuse, specular, shininess, headLight, leastGradient}) {
        if (!(value >= 0) || !std::isfinite(value)) {
            throw ParameterError(fmt::format("shading value {} must be a number not below 0", value));
        }
    }
    for (const DirectionalLight& light : lights) {
        const auto& [x, y, z] = std::array{light.direction.x, light.direction.y, light.direction.z};
        if (!(glm::length(light.direction) > 0) || !std::isfinite(x + y + z)) {
            throw ParameterError(fmt::format("light direction {} {} {} must be finite and not zero", x, y, z));
        }
        if (!(light.intensity >= 0) || !std::isfinite(light.intensity)) {
            throw ParameterError(fmt::format("light intensity {} must be a number not below 0", light.intensity));
        }
    }
}

} // namespace vdblic
