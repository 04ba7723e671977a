#include "vdblic/methods/texture_params.h"

#include "vdblic/methods/registry.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <vector>

namespace vdblic {
namespace {

/// Descriptions of all methods: "auflic: accelerated UFLIC; lic: each frame on its own."
const std::string& methodTexts()
{
    static const std::string text = [] {
        std::vector<std::string> texts;
        for (const TextureMethod* const method : textureMethods())
            texts.push_back(fmt::format("{}: {}", method->name, method->text));
        return fmt::format("{}.", fmt::join(texts, "; "));
    }();
    return text;
}

Parameter methodParameter(TextureParams& params)
{
    Parameter result = parameter(
        "method", methodTexts(), WordType::kText, 1,
        [&params](const Words& words) { params.method = &textureMethod(words.front()); },
        [&params] { return Words{std::string(params.method->name)}; }, {.words = "METHOD"});
    for (const TextureMethod* const method : textureMethods())
        result.choices.emplace_back(method->name);
    if (std::find(result.choices.begin(), result.choices.end(), params.method->name) == result.choices.end())
        result.choices.emplace_back(params.method->name); // a method of the calling program
    return result;
}

} // namespace

Parameters parametersOf(TextureParams& params)
{
    const Parameters own = {
        methodParameter(params),
        parameter("life_span", "Life span of a seed, with lic and ufac the length of the kernel.", params.lifeSpan,
                  {.option = "--life", .unit = "frames", .limits = {1, 1000}}),
        parameter("substeps", "Textures for each interval between frames.", params.substeps,
                  {.limits = {1, TextureParams::kMostSubsteps}}),
        parameter("release_window", "auflic, auflic-2004: part of a frame in which a pathline takes up seeds.",
                  params.releaseWindow, {.limits = {0, 1, true}}),
    };
    return joined({own, parametersOf(params.pathline), parametersOf(params.feedback)});
}

void TextureParams::validate() const
{
    TextureParams copy = *this;
    checkLimits(parametersOf(copy));
    feedback.validate();
}

} // namespace vdblic
