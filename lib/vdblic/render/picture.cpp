#include "vdblic/render/picture.h"

#include "vdblic/camera/camera.h"
#include "vdblic/cast/ground_plane.h"
#include "vdblic/cast/ray_caster.h"
#include "vdblic/cast/tube_caster.h"
#include "vdblic/image/color_map.h"
#include "vdblic/image/image_file.h"
#include "vdblic/image/vector_text.h"
#include "vdblic/io/sequence.h"
#include "vdblic/look/look.h"
#include "vdblic/render/annotations.h"
#include "vdblic/render/nothing_seen.h"
#include "vdblic/render/render_plan.h"

#include <fmt/format.h>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

/// Attributes that are not called as their parameters; empty: none.
constexpr auto kNamesOfTheirOwn =
    std::to_array<std::pair<std::string_view, std::string_view>>({{"annotate", "annotations"},
                                                                  {"background", "backgroundColor"},
                                                                  {"by", ""},
                                                                  {"camera", "cameraKeys"},
                                                                  {"clip_plane", "clipPlanes"},
                                                                  {"colormap", "colorMap"},
                                                                  {"fov", "fieldOfView"},
                                                                  {"light", ""},
                                                                  {"modulate", "textureStrength"},
                                                                  {"range", "colorRange"},
                                                                  {"roi", "region"},
                                                                  {"roi_box", "regionBox"},
                                                                  {"size", ""},
                                                                  {"texture", "textureGrid"},
                                                                  {"transfer", ""}});

/// The name of a parameter's attribute: its own, else the key in camel case; empty for none.
std::string attributeOf(std::string_view key)
{
    for (const auto& [own, name] : kNamesOfTheirOwn) {
        if (own == key) return std::string(name);
    }
    std::string name;
    for (const char letter : key) {
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

/// The header of a frame's image: all parameters that made it. An attribute of several numbers is spelled as on the
/// command line.
ImageHeader imageHeader(const PicturePlan& plan, const Look& look, const Camera& camera, const LoadedTexture& frame)
{
    ImageHeader header;
    header.worldToCamera = camera.worldToCamera();
    header.worldToNdc = camera.worldToNdc();
    header.screenWindowWidth = float(2 * camera.halfExtent().x);
    auto& attributes = header.attributes;
    attributes = {{"frame", int(frame.file.frame)}, {"source", frame.file.path.filename().string()}};
    if (frame.after > 0) attributes.emplace_back("moment", float(frame.frame()));
    const PicturePlan all = chosen(plan, look, camera);
    PictureParams params = all.params();
    params.cameraFile = std::filesystem::path(plan.cameraFile).filename();
    params.lines = std::filesystem::path(plan.lines).filename();
    for (const Parameter& parameter : parametersOf(params)) {
        const std::string name = attributeOf(parameter.key);
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

/// Cubic where linear interpolation would be seen as a pattern of voxels. One choice for all frames of a film.
Interpolation interpolationFor(const View& view, const PlacedBox& box)
{
    constexpr double kWidePixels = 3;
    const double pixel = view.cameras.first().pixelSize(middleOf(view.box));
    return box.voxelSize() > kWidePixels * pixel ? Interpolation::kCubic : Interpolation::kLinear;
}

} // namespace

Picture::Picture(const PicturePlan& plan, const View& view, std::shared_ptr<const ShownVolume> shown,
                 const PictureShare* share)
    : mPlan(plan), mView(view), mShown(std::move(shown)), mShare(share), mExchange(share ? share->exchange : mAlone),
      mRays(plan.rays), mCamera(view.cameras.at(mShown->frame().frame()))
{
    mRays.clip = plan.rays.clip.stretched(plan.stretch);
    if (!mRays.interpolation) mRays.interpolation = interpolationFor(view, mShown->frame().box());
    const Look& look = view.look;
    const LoadedTexture& frame = mShown->frame();
    const Solid* const solid = mShown->solid();
    const glm::dvec3 light = keyLight(look, mCamera);
    if (mShown->ambient()) mLight.emplace(*mShown->extinctions(), *mShown->ambient(), frame.box(), look, light);
    if (plan.ground != GroundSide::kNone) {
        const std::vector<ClipPlane> cuts = mRays.clip.allPlanes();
        // Automatic cameras may look along up and then have another one.
        const glm::dvec3 up = plan.motion.keys.empty() ? plan.camera.up.value_or(glm::dvec3(0, 0, 1)) : mCamera.up();
        const GroundPlane plane = groundPlane(plan.ground, up, view.box, solid);
        mGround.emplace(plane, ShadowCasters{*mShown->extinctions(), frame.box(), cuts, solid}, light);
    }
    const Scenery scenery{.solid = solid,
                          .solidColor = glm::vec3(linearFromDisplay(plan.solidColor)),
                          .light = mLight ? &*mLight : nullptr,
                          .ground = mGround ? &*mGround : nullptr,
                          .tubes = frame.lines ? mShown->tree() : nullptr,
                          .tubesLook = view.lines ? &view.lines->look : nullptr};
    const auto cast = [&frame, &look, visible = mShown->visible(), tree = mShown->tree(), this,
                       scenery](const Camera& camera, int ray, const std::uint8_t* only, const std::stop_token& stop) {
        return visible ? castRays(*frame.volume, look, camera, mRays, *visible, ray, scenery, only, stop)
                       : castTubes(*tree, look, camera, mRays, ray, scenery, only, stop);
    };
    mSum.emplace(cast, share ? mCamera.cropped(share->area()) : mCamera);
}

Image Picture::image() const
{
    const LoadedTexture& frame = mShown->frame();
    Image image = exposed(mSum->mean(), mView.look.exposure);
    if (mShare) mShare->assemble(image);
    if (mPlan.annotations.any() && mExchange.isFirst()) {
        const auto shown = [&](const std::string& name) { // without the speed, the texture colours
            return !frame.hasColor && name == mPlan.colorBy ? frame.name : name;
        };
        FrameClock clock = frame.clock;
        clock.longest = mView.longest;
        AnnotationContent::OfLines lines;
        if (frame.lines && mView.lines) lines = {&mView.lines->look, mView.lines->opacityBy, frame.lines->opacityUnit};
        const AnnotationContent content{mView.box,
                                        mPlan.stretch,
                                        shown(mPlan.colorBy),
                                        shown(mView.opacityBy),
                                        frame.file.frame,
                                        clock,
                                        mView.lastFrame,
                                        frame.colorUnit,
                                        frame.opacityUnit,
                                        frame.lengthUnit,
                                        isGeographic(clock, frame.lengthUnit, mPlan.stretch),
                                        std::move(lines)};
        annotate(image, mPlan.annotations, content, mView.look, mCamera, mPlan.background.at(0.5));
    }
    return image;
}

ImageHeader Picture::header() const
{
    PicturePlan plan = mPlan;
    plan.texture = mShown->frame().name;
    if (!plan.opacityBy.empty()) plan.opacityBy = {mView.opacityBy};
    plan.rays.interpolation = mRays.interpolation;
    return imageHeader(plan, mView.look, mCamera, mShown->frame());
}

std::string Picture::whyNothingIsSeen(const Image& image)
{
    const auto isSeen = [](const glm::vec4& pixel) { return pixel.a > 0; };
    const bool anySeen = std::any_of(image.pixels.begin(), image.pixels.end(), isSeen);
    if (mExchange.any(anySeen)) return {};
    return vdblic::whyNothingIsSeen(mShown->frame(), mView.look, mCamera, mRays, mExchange);
}

} // namespace vdblic
