#include "vdblic/render/render_params.h"

#include "vdblic/cast/supersampling.h"
#include "vdblic/core/errors.h"
#include "vdblic/image/vector_text.h"
#include "vdblic/io/texture_name.h"
#include "vdblic/look/histogram.h"
#include "vdblic/look/look_preset.h"
#include "vdblic/look/transfer_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/vec4.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace vdblic {
namespace {

constexpr int kMostPixels = 32768; // a side
constexpr double kMostStretch = 1e6;

void setLook(RenderParams& params, const std::string& name)
{
    const LookPreset preset = lookPreset(name);
    params.lookName = name;
    params.look = preset.look;
    params.background = preset.background;
    params.opacityBy = preset.opacityBy;
}

} // namespace

RenderParams defaultRenderParams(bool isSparse)
{
    RenderParams params;
    setLook(params, defaultLookName(isSparse));
    return params;
}

Parameters pictureParametersOf(RenderParams& params)
{
    Parameter look = parameter(
        "look", "Look that all other options start from; by default flow, of files of streaks streaks.",
        WordType::kText, 1, [&params](const Words& words) { setLook(params, words[0]); },
        [&params] { return Words{params.lookName}; }, {.words = "NAME", .group = "Picture", .attribute = "look"});
    look.choices = lookPresetNames();
    const auto setBy = [&params](const Words& words) {
        params.colorBy = words[0];
        params.opacityBy.clear();
    };
    const auto opacityBy = [&params] {
        return params.opacityBy.empty() ? Words{params.colorBy} : Words{params.opacityBy.front()};
    };
    const auto annotations = [&params] {
        return params.annotations.any() ? Words{annotationText(params.annotations)} : Words{};
    };
    const Parameters picture = {
        look,
        parameter("texture",
                  "Float grid that holds the texture; by default the one that vdblic_advect made, else density.",
                  params.texture, {.words = "NAME", .group = "Picture", .isFile = true, .attribute = "textureGrid"}),
        parameter("size", "Size of the image.", params.size,
                  {.unit = "pixels", .words = "W H", .group = "Picture", .attribute = "-"}),
        parameter("scale", "Factor on the size, for previews.", params.scale,
                  {.group = "Picture", .limits = {0, kMostPixels, true}}),
        parameter("samples", "Rays to a pixel, at points of a low-discrepancy pattern.", params.samples,
                  {.group = "Picture", .limits = {1, kMostSamples}}),
        parameter("stretch",
                  "Factors on the world's axes, such as 1 1 20 to exaggerate heights; camera and lights stand in the "
                  "stretched space, cuts in the data's own.",
                  params.stretch, {.words = "X Y Z", .group = "Camera", .limits = {1 / kMostStretch, kMostStretch}}),
    };
    const Parameters shown = {
        parameter("roi", "Grid whose active voxels are all that is shown.", params.region,
                  {.words = "FILE[:GRID]", .group = "Cuts", .isFile = true, .attribute = "region"}),
        parameter("roi_box", "Low and high corner of a box; only voxels with their centre inside are shown.",
                  params.regionBox,
                  {.unit = "world", .words = "X Y Z X Y Z", .group = "Cuts", .attribute = "regionBox"}),
    };
    const Parameters annotate = {
        parameter(
            "annotate",
            "Explanations over the picture: box, axes, colorbar, time, scalebar, triad, title=TEXT. In .exr channels "
            "of their own, annotation.R and so on.",
            WordType::kText, 1, [&params](const Words& words) { params.annotations = parseAnnotations(words[0]); },
            annotations, {.words = "NAME,NAME", .group = "Picture", .attribute = "annotations"}),
    };
    const Parameters scalars = {
        parameter("by", "Float grid that colour and opacity follow; magnitude by default.", WordType::kText, 1, setBy,
                  [] { return Words{}; }, {.words = "NAME", .group = "Colour and opacity", .attribute = "-"}),
        parameter("color_by", "Float grid that colour follows.", params.colorBy,
                  {.words = "NAME", .group = "Colour and opacity"}),
        parameter("opacity_by", "Float grid that opacity follows.", WordType::kText, 1,
                  [&params](const Words& words) { params.opacityBy = {words[0]}; }, opacityBy,
                  {.words = "NAME", .group = "Colour and opacity"}),
        parameter(
            "transfer", "JSON file of a transfer function (docs/formats.md).", WordType::kText, 1,
            [&params](const Words& words) { readTransferFile(words[0], params.look.transfer); }, [] { return Words{}; },
            {.words = "FILE", .group = "Colour and opacity", .isFile = true, .attribute = "-"}),
    };
    return joined({picture, parametersOf(params.camera), parametersOf(params.motion), scalars,
                   parametersOf(params.look), parametersOf(params.rays), shown, parametersOf(params.solid),
                   parametersOf(params.ground), annotate, parametersOf(params.background)});
}

namespace {

/// The textures to render, which choose the look that all other parameters are set on top of.
Parameters inputParameters(RenderParams& params)
{
    Parameters input = parametersOf(params.input, "TEXTURE",
                                    "Texture volumes: one file, a pattern (name.%04d.vdb, also ####, @@@@, $F4, <F4>), "
                                    "or - for paths on standard input.");
    for (Parameter& parameter : input) {
        if (parameter.key != "input") continue;
        parameter.set = [&params, set = parameter.set](const Words& words) {
            set(words);
            setLook(params, defaultLookName(isSparse(params.input)));
        };
    }
    return input;
}

} // namespace

Parameters parametersOf(RenderParams& params)
{
    const Parameters outputs = {
        parameter("output",
                  "Image or pattern of images, .exr (linear, premultiplied alpha) or .png (8 bit sRGB, opaque). May be "
                  "left out with a film, a histogram or a transfer function to write.",
                  params.output, {.option = "-o,--output", .group = "Output", .isFile = true}),
        skipExistingParameter(params.skipExisting),
        parameter("keep_going", "Leave out frames that cannot be read; the exit status tells at the end.",
                  params.keepGoing, {.group = "Output"}),
    };
    const Parameters further = {
        parameter("histogram", "Histograms of texture and scalars with the transfer function over them, .png or .json.",
                  params.histogram, {.words = "FILE", .group = "Output", .isFile = true}),
        parameter("transfer_out", "JSON file for the range, colours and opacity that are rendered with.",
                  params.transferOut, {.words = "FILE", .group = "Output", .isFile = true}),
        parameter("film", "Film of all frames, .mp4, made by ffmpeg.", params.film,
                  {.words = "FILE", .group = "Output", .isFile = true}),
        parameter("fps", "Frames of the film a second.", params.framesPerSecond,
                  {.group = "Output", .limits = {0.01, 1000}}),
    };
    return joined({inputParameters(params), outputs, pictureParametersOf(params), parametersOf(params.exr), further});
}

void RenderParams::validate() const
{
    if (output.empty() && film.empty() && histogram.empty() && transferOut.empty())
        throw ParameterError("there is nothing to make: give an output");
    if (!film.empty() && std::filesystem::path(film).extension() != ".mp4")
        throw ParameterError(fmt::format("film '{}' must end in .mp4", film));
    if (!film.empty() && skipExisting)
        throw ParameterError("a film needs the pictures of all frames; existing ones cannot be skipped");
    RenderParams copy = *this;
    checkLimits(parametersOf(copy));
    if (!output.empty()) {
        const bool exrOutput = imageFormat(output) == ImageFormat::kExr;
        if (!exr.layers.empty() && !exrOutput) {
            throw ParameterError(fmt::format("output '{}': only .exr holds further channels", output));
        }
    }
    if (!histogram.empty()) checkHistogramPath(histogram);
    validatePicture();
}

void RenderParams::validatePicture() const
{
    RenderParams copy = *this;
    checkLimits(pictureParametersOf(copy));
    camera.validate();
    motion.validate();
    look.validate();
    solid.validate();
    ground.validate();
    rays.validate();
    background.validate();
    exr.validate();
    if (motion.orbit != 0 && !motion.orbitFrames && (input.pattern == "-" || !FramePattern(input.pattern).hasField())) {
        throw ParameterError("how many frames the orbit takes must be given, since the input does not tell");
    }
    if (regionBox) {
        const auto& b = *regionBox;
        const bool isFinite = std::all_of(b.begin(), b.end(), [](double c) { return std::isfinite(c); });
        if (!isFinite || !(b[0] < b[3] && b[1] < b[4] && b[2] < b[5]))
            throw ParameterError(fmt::format("region box {} must be a low and a high corner", fmt::join(b, " ")));
    }
    for (const glm::ivec2& sides : {size, scaledSize()}) {
        if (std::min(sides.x, sides.y) >= 1 && std::max(sides.x, sides.y) <= kMostPixels) continue;
        throw ParameterError(
            fmt::format("image size {}x{} must be 1 to {} pixels a side", sides.x, sides.y, kMostPixels));
    }
}

glm::ivec2 RenderParams::scaledSize() const
{
    const auto scaled = [&](int side) { return int(std::clamp(std::round(side * scale), 1.0, 1e9)); };
    return {scaled(size.x), scaled(size.y)};
}

double RenderParams::imageBytes() const
{
    // The sum over the samples, one sample, the file's pixels, and the file.
    const double layerBytes = rays.layers ? 2 * sizeof(PixelLayers) : 0;
    const bool hasSurface = !solid.source.empty() || ground.side != GroundSide::kNone;
    const double surfaceBytes = hasSurface ? sizeof(float) + sizeof(glm::vec4) + sizeof(glm::vec3) : 0;
    // Two drawings of 32 bits, and both in linear light.
    const double annotationBytes = annotations.any() ? 2 * (sizeof(float) + sizeof(glm::vec4)) : 0;
    const double perPixel =
        sizeof(glm::vec4) * 4 + layerBytes + surfaceBytes + annotationBytes + (film.empty() ? 0 : 3);
    return double(scaledSize().x) * scaledSize().y * perPixel;
}

} // namespace vdblic
