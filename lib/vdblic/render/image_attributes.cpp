#include "vdblic/render/image_attributes.h"

#include "vdblic/camera/camera.h"
#include "vdblic/image/vector_text.h"
#include "vdblic/io/sequence.h"
#include "vdblic/look/look.h"
#include "vdblic/render/render_params.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

using Attributes = std::vector<std::pair<std::string, ImageAttribute>>;

// Each of these names all members of a struct: a new member does not compile until it is handled here.

template<typename Items, typename Text>
std::string listText(const Items& items, const Text& itemText)
{
    std::vector<std::string> parts;
    parts.reserve(items.size());
    for (const auto& item : items)
        parts.push_back(itemText(item));
    return fmt::format("{}", fmt::join(parts, ", "));
}

void add(Attributes& attributes, const Camera& camera)
{
    attributes.insert(attributes.end(), {{"projection", std::string(toString(camera.projection()))},
                                         {"eye", glm::vec3(camera.eye())},
                                         {"target", glm::vec3(camera.target())},
                                         {"up", glm::vec3(camera.up())}});
    if (camera.projection() == Projection::kPerspective) {
        attributes.emplace_back("fieldOfView", float(camera.fieldOfView()));
    } else {
        attributes.emplace_back("viewHeight", float(2 * camera.halfExtent().y));
    }
}

void add(Attributes& attributes, const CameraMotion& motion)
{
    const auto& [orbit, orbitFrames, keys] = motion;
    attributes.emplace_back("orbit", float(orbit));
    if (orbitFrames) attributes.emplace_back("orbitFrames", int(*orbitFrames));
    if (!keys.empty()) attributes.emplace_back("cameraKeys", keys.file.filename().string());
}

void add(Attributes& attributes, const TransferFunction& transfer)
{
    const auto& [colorMap, colors, opacity, range, opacityRange, colorScale, opacityScale, unit, opacityUnit] =
        transfer.params();
    const auto colorText = [](const ColorPoint& point) {
        return fmt::format("{}:{}", point.position, vectorText(point.color));
    };
    attributes.emplace_back("colorMap", colors.empty() ? colorMap : listText(colors, colorText));
    attributes.emplace_back("opacity", opacityText(opacity));
    const auto [low, high] = transfer.opacityRange();
    attributes.emplace_back("colorRange", glm::vec2((*range)[0], (*range)[1]));
    attributes.emplace_back("opacityRange", glm::vec2(low, high));
    attributes.emplace_back("colorScale", std::string(valueScaleName(colorScale)));
    attributes.emplace_back("opacityScale", std::string(valueScaleName(transfer.opacityAxis().scale)));
    if (!unit.empty()) attributes.emplace_back("unit", unit);
    if (!opacityUnit.empty()) attributes.emplace_back("opacityUnit", opacityUnit);
}

void add(Attributes& attributes, const TextureModulation& texture)
{
    attributes.insert(attributes.end(), {{"textureRange", glm::vec2(texture.low, texture.high)},
                                         {"textureStrength", texture.strength},
                                         {"limbDarkening", texture.limbDarkening},
                                         {"textureFoot", texture.foot}});
}

void add(Attributes& attributes, const Shading& shading)
{
    const auto& [model, ambient, diffuse, specular, shininess, headLight, lights, leastGradient] = shading;
    const auto lightText = [](const DirectionalLight& light) {
        return fmt::format("{} {}", vectorText(light.direction), light.intensity);
    };
    attributes.insert(attributes.end(), {{"shading", std::string(shadingModelName(model))},
                                         {"ambient", ambient},
                                         {"diffuse", diffuse},
                                         {"specular", specular},
                                         {"shininess", shininess},
                                         {"headLight", headLight},
                                         {"lights", listText(lights, lightText)},
                                         {"leastGradient", leastGradient}});
}

void add(Attributes& attributes, const RayCastParams& rays)
{
    const auto& [step, leastTransmittance, clip, layers] = rays;
    const auto& [planes, box] = clip;
    const auto planeText = [](const ClipPlane& plane) {
        return fmt::format("{} {}", vectorText(plane.point), vectorText(plane.normal));
    };
    attributes.emplace_back("step", float(step));
    attributes.emplace_back("leastTransmittance", float(leastTransmittance));
    attributes.emplace_back("clipPlanes", listText(planes, planeText));
    attributes.emplace_back("clipBox",
                            box ? fmt::format("{} {}", vectorText((*box)[0]), vectorText((*box)[1])) : std::string());
}

} // namespace

ImageHeader imageHeader(const RenderParams& params, const Look& look, const Camera& camera, const FrameFile& file)
{
    ImageHeader header;
    header.worldToCamera = camera.worldToCamera();
    header.worldToNdc = camera.worldToNdc();
    header.screenWindowWidth = float(2 * camera.halfExtent().x);
    const auto& [input, skipExisting, keepGoing, output, film, framesPerSecond, annotations, transferOut, histogram,
                 texture, colorBy, opacityBy, region, regionBox, solid, stretch, size, scale, samples, cameraParams,
                 motion, lookParams, rays, background, exr] = params;
    const auto& [transfer, modulation, shading, halo, depthCue, shadows, fading] = look;
    Attributes& attributes = header.attributes;
    attributes = {{"frame", int(file.frame)},
                  {"source", file.path.filename().string()},
                  {"textureGrid", texture},
                  {"colorBy", colorBy},
                  {"opacityBy", opacityBy.empty() ? colorBy : opacityBy.front()},
                  {"region", region},
                  {"regionBox", regionBox ? fmt::format("{}", fmt::join(*regionBox, " ")) : std::string()},
                  {"stretch", glm::vec3(stretch)},
                  {"scale", float(scale)},
                  {"samples", samples},
                  {"halo", halo.strength},
                  {"depthCue", depthCue},
                  {"shadows", shadows},
                  {"solid", solid.source},
                  {"solidColor", glm::vec3(solid.color)},
                  {"opticalDepth", float(lookParams.opticalDepth)},
                  {"backgroundColor", glm::vec3(background.color)},
                  {"annotations", annotationText(annotations)},
                  {"backgroundAlpha", float(background.alpha)}};
    add(attributes, camera);
    add(attributes, motion);
    add(attributes, transfer);
    add(attributes, modulation);
    add(attributes, shading);
    add(attributes, rays);
    return header;
}

} // namespace vdblic
