#include "vdblic/render/image_attributes.h"

#include "vdblic/camera/camera.h"
#include "vdblic/image/vector_text.h"
#include "vdblic/io/sequence.h"
#include "vdblic/look/look.h"
#include "vdblic/render/render_plan.h"

#include <fmt/format.h>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cctype>
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

/// The name of a parameter's attribute: its own, else the key in camel case; empty for none.
std::string attributeOf(const Parameter& parameter)
{
    if (parameter.info.attribute == "-") return {};
    if (!parameter.info.attribute.empty()) return std::string(parameter.info.attribute);
    std::string name;
    for (const char letter : parameter.key) {
        const bool starts = !name.empty() && name.back() == '_';
        if (starts) name.pop_back();
        name += starts ? char(std::toupper(static_cast<unsigned char>(letter))) : letter;
    }
    return name;
}

/// Words that may be repeated, with commas between the values.
std::string repeatedText(const Parameter& parameter, const Words& words)
{
    std::string text;
    for (std::size_t i = 0; i < words.size(); ++i)
        text += (i == 0 ? "" : i % parameter.least == 0 ? ", " : " ") + words[i];
    return text;
}

ImageAttribute valueOf(const Parameter& parameter, const Words& words)
{
    const auto number = [&](std::size_t i) { return float(detail::numberIn(words[i]).value()); };
    const bool isNumber = parameter.type == WordType::kNumber && !parameter.repeats;
    if (parameter.type == WordType::kInteger && words.size() == 1) return int(detail::integerIn(words[0]).value());
    if (isNumber && words.size() == 1) return number(0);
    if (isNumber && words.size() == 2) return glm::vec2(number(0), number(1));
    if (isNumber && words.size() == 3) return glm::vec3(number(0), number(1), number(2));
    return repeatedText(parameter, words);
}

/// The plan with every choice that it leaves open filled in.
PicturePlan chosen(const PicturePlan& plan, const Look& look, const Camera& camera)
{
    PicturePlan result = plan;
    result.camera.eye = camera.eye();
    result.camera.target = camera.target();
    result.camera.up = camera.up();
    if (camera.projection() == Projection::kPerspective) {
        result.camera.fieldOfView = camera.fieldOfView();
    } else {
        result.camera.viewHeight = 2 * camera.halfExtent().y;
    }
    const auto [low, high] = look.transfer.opacityRange();
    result.look.transfer = look.transfer.params();
    result.look.transfer.opacityRange = {low, high};
    result.look.transfer.opacityScale = look.transfer.opacityAxis().scale;
    result.look.shading = look.shading;
    result.look.exposure = look.exposure;
    return result;
}

} // namespace

ImageHeader imageHeader(const PicturePlan& plan, const Look& look, const Camera& camera, const FrameFile& file)
{
    ImageHeader header;
    header.worldToCamera = camera.worldToCamera();
    header.worldToNdc = camera.worldToNdc();
    header.screenWindowWidth = float(2 * camera.halfExtent().x);
    auto& attributes = header.attributes;
    attributes = {{"frame", int(file.frame)}, {"source", file.path.filename().string()}};
    const PicturePlan all = chosen(plan, look, camera);
    PictureParams params = all.params();
    params.cameraFile = std::filesystem::path(plan.cameraFile).filename();
    for (const Parameter& parameter : parametersOf(params)) {
        const std::string name = attributeOf(parameter);
        const Words words = parameter.get();
        if (!name.empty() && !words.empty()) attributes.emplace_back(name, valueOf(parameter, words));
    }
    // Values that no option sets.
    const TransferParams& transfer = all.look.transfer;
    if (!transfer.unit.empty()) attributes.emplace_back("unit", transfer.unit);
    if (!transfer.opacityUnit.empty()) attributes.emplace_back("opacityUnit", transfer.opacityUnit);
    std::string lights;
    for (const DirectionalLight& light : look.shading.lights)
        lights += fmt::format("{}{} {}", lights.empty() ? "" : ", ", vectorText(light.direction), light.intensity);
    attributes.insert(attributes.end(), {{"lights", lights},
                                         {"leastGradient", look.shading.leastGradient},
                                         {"opticalDepth", float(plan.look.opticalDepth)},
                                         {"leastTransmittance", float(plan.rays.leastTransmittance)},
                                         {"textureRange", glm::vec2(look.texture.low, look.texture.high)},
                                         {"textureFoot", look.texture.foot}});
    return header;
}

} // namespace vdblic
