#include "vdblic/look/shading.h"

#include "vdblic/core/errors.h"
#include "vdblic/image/vector_text.h"

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include <array>
#include <cmath>

namespace vdblic {
Parameters parametersOf(Shading& params)
{
    const auto setLights = [&params](const Words& words) {
        params.lights.clear();
        for (std::size_t i = 0; i < words.size(); i += 3)
            params.lights.push_back({WordsOf<glm::dvec3>::read({words[i], words[i + 1], words[i + 2]})});
    };
    const auto lights = [&params] {
        Words words;
        for (const DirectionalLight& light : params.lights) {
            const Words direction = WordsOf<glm::dvec3>::write(light.direction);
            words.insert(words.end(), direction.begin(), direction.end());
        }
        return words;
    };
    Parameter light = parameter("light", "Direction towards a far-away light, in place of the look's; may be repeated.",
                                WordType::kNumber, 3, setLights, lights, {.unit = "world", .words = "X Y Z"});
    light.repeats = true;
    return {
        parameter("shading",
                  "phong: by the texture's gradient; lines: as thin lines, by the direction the texture changes least "
                  "in; none.",
                  params.model, {.words = "HOW"}),
        parameter("head_light", "Intensity of the light at the eye.", params.headLight, {.limits = {0, 1e9}}),
        light,
    };
}

void Shading::validate() const
{
    Shading copy = *this;
    checkLimits(parametersOf(copy));
    if (!(leastGradient >= 0) || !std::isfinite(leastGradient))
        throw ParameterError(fmt::format("shading value {} must be a number not below 0", leastGradient));
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
