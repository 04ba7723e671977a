#include "vdblic/render/render_plan.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/texture_name.h"
#include "vdblic/look/look_preset.h"
#include "vdblic/look/transfer_file.h"

#include <algorithm>
#include <utility>

namespace vdblic {
namespace {

Parameters optionsOf(LookPreset& look)
{
    return joined({parametersOf(look.look), parametersOf(look.background)});
}

LookPreset lookOf(const PictureParams& params, const SequenceTraits& sequence)
{
    LookPreset look = lookPreset(params.look.empty() ? defaultLookName(sequence.isSparse) : params.look);
    if (!params.transferFile.empty()) readTransferFile(params.transferFile, look.look.transfer);
    set(optionsOf(look), params.lookOptions);
    look.look.validate();
    look.background.validate();
    return look;
}

/// The grids that opacity may follow, the best one first.
std::vector<std::string> opacityGrids(const PictureParams& params, const LookPreset& look,
                                      const SequenceTraits& sequence)
{
    if (!params.opacityBy.empty()) return {params.opacityBy};
    if (!params.by.empty()) return {};
    const std::vector<std::string>& wanted = look.opacityBy;
    const auto found =
        std::find_first_of(wanted.begin(), wanted.end(), sequence.scalars.begin(), sequence.scalars.end());
    return found == wanted.end() ? wanted : std::vector{*found};
}

/// Who chose the values of a plan.
std::vector<std::string> choicesOf(PictureParams said, const PicturePlan& plan)
{
    PictureParams none, all = plan.params();
    LookPreset look = lookPreset(plan.lookName);
    const Parameters byLook = optionsOf(look);
    return planLines(parametersOf(none), parametersOf(said), parametersOf(all), [&](const Parameter& parameter) {
        const Parameter* const ofLook = find(byLook, parameter.key);
        return !ofLook                                ? "chosen"
               : ofLook->value() == parameter.value() ? "by the look " + plan.lookName
                                                      : "by " + said.transferFile;
    });
}

/// Key frames of a camera file. @throws ParameterError if file and parameters set the same value
CameraKeys keysOf(const std::string& file, const CameraParams& camera)
{
    CameraKeys keys = readCameraKeys(file);
    const std::pair<std::string_view, bool> twice[] = {
        {"eye", !keys.eye.empty() && camera.eye},
        {"angles", !keys.eye.empty() && camera.angles},
        {"view", !keys.eye.empty() && camera.view != CameraParams().view},
        {"target", !keys.target.empty() && camera.target},
        {"up", !keys.up.empty() && camera.up},
        {"view_height", !keys.viewHeight.empty() && camera.viewHeight},
        {"fov", !keys.fieldOfView.empty() && camera.fieldOfView != CameraParams().fieldOfView}};
    for (const auto& [name, isTwice] : twice) {
        if (isTwice)
            throw ParameterError(fmt::format("{}: its key frames stand against `{}`; leave one out", file, name));
    }
    return keys;
}

} // namespace

SequenceTraits traitsOf(const SequenceParams& sequence)
{
    return {.isSparse = isSparse(sequence),
            .isNumbered = sequence.pattern != "-" && FramePattern(sequence.pattern).hasField()};
}

PicturePlan resolve(const PictureParams& params, const SequenceTraits& sequence)
{
    params.validate();
    LookPreset look = lookOf(params, sequence);
    std::vector<std::string> opacityBy = opacityGrids(params, look, sequence);
    const PictureSettings& settings = params;
    PicturePlan plan{settings,        std::move(look.name), std::move(look.look),
                     look.background, params.colorBy,       std::move(opacityBy)};
    if (plan.colorBy.empty()) plan.colorBy = params.by.empty() ? kSpeedGrid : params.by;
    if (plan.texture.empty()) plan.texture = sequence.texture;
    constexpr double kSeenThrough = 4; // so that lines inside are seen
    if (!plan.lines.empty()) plan.look.opticalDepth /= kSeenThrough;
    if (!params.cameraFile.empty()) plan.motion.keys = keysOf(params.cameraFile, params.camera);
    plan.motion.validate();
    if (plan.motion.orbit != 0 && !plan.motion.orbitFrames && !sequence.isNumbered)
        throw ParameterError("how many frames the orbit takes must be given, since the input does not tell");
    return plan;
}

PicturePlan planOfLines(const PicturePlan& plan)
{
    PicturePlan lines = plan;
    lines.lines.clear();
    lines.texture.clear();
    lines.region.clear();
    lines.regionBox.reset();
    lines.look.opticalDepth = lookPreset(defaultLookName(/*isSparse=*/true)).look.opticalDepth;
    TransferParams& transfer = lines.look.transfer;
    transfer.opacity.clear();
    transfer.opacityRange.reset();
    transfer.opacityScale.reset();
    for (const char* const name : {"q", "vorticity", plan.colorBy.c_str()}) {
        if (!std::ranges::count(lines.opacityBy, name)) lines.opacityBy.emplace_back(name);
    }
    return lines;
}

RenderPlan resolve(const RenderParams& params)
{
    params.validate();
    const SequenceParams files = params.files();
    RenderPlan plan{.input = files,
                    .substeps = params.substeps,
                    .keepGoing = params.keepGoing,
                    .picture = resolve(params.picture, traitsOf(files)),
                    .outputs = params.outputs};
    if (plan.substeps > 1) plan.pictures = params.input.frames;
    plan.choices = choicesOf(params.picture, plan.picture);
    plan.picture.rays.layers = !params.outputs.exr.layers.empty();
    return plan;
}

PictureParams PicturePlan::params() const
{
    const PictureSettings& settings = *this;
    PictureParams params{settings, lookName, {}, {}, colorBy, opacityBy.empty() ? colorBy : opacityBy.front()};
    params.transferFile.clear(); // the look holds it
    LookPreset all{lookName, look, background};
    for (const Parameter& parameter : optionsOf(all)) {
        if (Words words = parameter.get(); !words.empty())
            params.lookOptions[std::string(parameter.key)] = std::move(words);
    }
    return params;
}

} // namespace vdblic
