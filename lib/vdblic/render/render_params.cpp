#include "vdblic/render/render_params.h"

#include "vdblic/cast/supersampling.h"
#include "vdblic/core/errors.h"
#include "vdblic/image/vector_text.h"
#include "vdblic/io/frame_pattern.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/look/histogram.h"
#include "vdblic/look/look_preset.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/vec4.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <utility>

namespace vdblic {
namespace {

constexpr int kMostPixels = 32768; // a side
constexpr double kMostStretch = 1e6;
constexpr int kMostSubsteps = 256;

/// Parameters whose values are kept as words until there is a look to set them on.
/// @param defaults the look that owns the parameters; it gives the values of unset ones
Parameters kept(Given& options, const Parameters& parameters, const std::shared_ptr<LookPreset>& defaults)
{
    Parameters result = parameters;
    for (Parameter& parameter : result) {
        const std::string key(parameter.key);
        parameter.set = [&options, key](const Words& words) { options[key] = words; };
        parameter.get = [&options, key, defaults, byDefault = parameter.get] {
            const auto given = options.find(key);
            return given == options.end() ? byDefault() : given->second;
        };
    }
    return result;
}

} // namespace

Parameters parametersOf(PictureParams& params)
{
    const auto defaults = std::make_shared<LookPreset>(lookPreset(defaultLookName(/*isSparse=*/false)));
    Parameter look = parameter(
        "look", "Look that all other options start from; by default flow, of files of streaks streaks.",
        WordType::kText, 1, [&params](const Words& words) { params.look = words[0]; },
        [&params, defaults] { return Words{params.look.empty() ? defaults->name : params.look}; }, {.words = "NAME"});
    look.choices = lookPresetNames();
    const auto colorBy = [&params] { return Words{params.colorBy.empty() ? kSpeedGrid : params.colorBy}; };
    const auto opacityBy = [&params] { return Words{params.opacityBy.empty() ? kSpeedGrid : params.opacityBy}; };
    const auto annotations = [&params] {
        return params.annotations.any() ? Words{annotationText(params.annotations)} : Words{};
    };
    const Parameters picture = {
        look,
        parameter("texture",
                  "Float grid that holds the texture; by default the one that vdblic_advect made, else density.",
                  params.texture, {.words = "NAME"}),
        parameter("size", "Size of the image.", params.size, {.unit = "pixels", .words = "W H"}),
        parameter("samples", "Rays to a pixel, at points of a low-discrepancy pattern.", params.samples,
                  {.limits = {1, kMostSamples}}),
        parameter("stretch",
                  "Factors on the world's axes, such as 1 1 20 to exaggerate heights; camera and lights stand in the "
                  "stretched space, cuts in the data's own.",
                  params.stretch, {.words = "X Y Z", .limits = {1 / kMostStretch, kMostStretch}}),
        parameter("roi", "Grid whose active voxels are all that is shown.", params.region, {.words = "FILE[:GRID]"}),
        parameter("roi_box", "Low and high corner of a box; only voxels with their centre inside are shown.",
                  params.regionBox, {.unit = "world", .words = "X Y Z X Y Z"}),
        parameter(
            "annotate",
            "Explanations over the picture: box, axes, colorbar, time, scalebar, triad, on a globe place=LONGITUDE "
            "LATITUDE NAME, title=TEXT. In .exr channels of their own, annotation.R and so on.",
            WordType::kText, 1, [&params](const Words& words) { params.annotations = parseAnnotations(words[0]); },
            annotations, {.words = "NAME,NAME"}),
        parameter("camera", "JSON file of key frames of the camera (docs/formats.md).", params.cameraFile,
                  {.words = "FILE"}),
        parameter("by", "Float grid that colour and opacity follow; magnitude by default.", params.by,
                  {.words = "NAME"}),
        parameter("color_by", "Float grid that colour follows.", WordType::kText, 1,
                  [&params](const Words& words) { params.colorBy = words[0]; }, colorBy, {.words = "NAME"}),
        parameter("opacity_by", "Float grid that opacity follows.", WordType::kText, 1,
                  [&params](const Words& words) { params.opacityBy = words[0]; }, opacityBy, {.words = "NAME"}),
        parameter("transfer", "JSON file of a transfer function (docs/formats.md).", params.transferFile,
                  {.words = "FILE"}),
        parameter("lines",
                  "Streaks drawn as tubes in a texture of voxels: one file of vdblic_advect --method streaks, or a "
                  "pattern with the texture's frame numbers. Colours are the texture's; opacity follows the grid of "
                  "--opacity-by, q or vorticity, the first that the lines carry.",
                  params.lines, {.words = "FILE"}),
        parameter("solid",
                  "Opaque body: a closed mesh (.obj, .stl, .ply), level set, fog volume or mask, one file or a "
                  "sequence; or domain, what the texture leaves out of its box.",
                  params.solid, {.words = "FILE[:GRID] or domain"}),
        parameter("solid_color", "Colour of the solid as displayed.", params.solidColor,
                  {.words = "R G B", .limits = {0, 1}}),
        parameter("earth",
                  "Draw continents and a graticule of 15 degrees on the solid, as those of a globe around the world's "
                  "origin: z leads to the north pole, x to 0 degrees east.",
                  params.earth),
        parameter("ground",
                  "Plane below the domain, or along one of its walls, that takes the shadows of volume and solid and "
                  "fades into the background; seen from the domain's side alone.",
                  params.ground, {.words = "SIDE"}),
    };
    return joined({picture, parametersOf(params.camera), parametersOf(params.motion),
                   kept(params.lookOptions, parametersOf(defaults->look), defaults), parametersOf(params.rays),
                   kept(params.lookOptions, parametersOf(defaults->background), defaults)});
}

Parameters parametersOf(RenderParams& params)
{
    RenderOutputs& to = params.outputs;
    const Parameters outputs = {
        parameter("output",
                  "Image or pattern of images, .exr (linear, premultiplied alpha) or .png (8 bit sRGB, opaque). May be "
                  "left out with a film, a histogram or a transfer function to write.",
                  to.images, {.option = "-o,--output"}),
        skipExistingParameter(to.skipExisting),
        parameter(
            "substeps",
            "Pictures of lines for each interval between frames: the lines move on along their paths. Pictures are "
            "numbered as by vdblic_advect --substeps, and --frames selects them by these numbers.",
            params.substeps, {.limits = {1, kMostSubsteps}}),
        parameter("keep_going", "Leave out frames that cannot be read; the exit status tells at the end.",
                  params.keepGoing),
        parameter("histogram", "Histograms of texture and scalars with the transfer function over them, .png or .json.",
                  to.histogram, {.words = "FILE"}),
        parameter("transfer_out", "JSON file for the range, colours and opacity that are rendered with.",
                  to.transferFunction, {.words = "FILE"}),
        parameter("film", "Film of all frames, .mp4, made by ffmpeg.", to.film, {.words = "FILE"}),
        parameter("fps", "Frames of the film a second.", to.framesPerSecond, {.limits = {0.01, 1000}}),
    };
    return joined(
        {parametersOf(params.input, "TEXTURE",
                      "Texture volumes: one file, a pattern (name.%04d.vdb, also ####, @@@@, $F4, <F4>), or - "
                      "for paths on standard input."),
         outputs, parametersOf(params.picture), parametersOf(to.exr)});
}

void RenderOutputs::validate() const
{
    if (images.empty() && film.empty() && histogram.empty() && transferFunction.empty())
        throw ParameterError("there is nothing to make: give an output");
    if (!film.empty() && std::filesystem::path(film).extension() != ".mp4")
        throw ParameterError(fmt::format("film '{}' must end in .mp4", film));
    if (!film.empty() && skipExisting)
        throw ParameterError("a film needs the pictures of all frames; existing ones cannot be skipped");
    if (!images.empty() && imageFormat(images) != ImageFormat::kExr && !exr.layers.empty())
        throw ParameterError(fmt::format("output '{}': only .exr holds further channels", images));
    if (!histogram.empty()) checkHistogramPath(histogram);
    exr.validate();
}

void RenderParams::validate() const
{
    RenderParams copy = *this;
    checkLimits(parametersOf(copy));
    outputs.validate();
    picture.validate();
    if (substeps > 1) {
        if (!FramePattern(input.pattern).hasField())
            throw ParameterError(
                fmt::format("`substeps` move lines from frame to frame, and '{}' is no pattern such as "
                            "name.%04d.vdb",
                            input.pattern));
        if (!picture.lines.empty())
            throw ParameterError("`substeps` move lines, and the texture of `lines` stays: leave one out");
    }
    if (picture.earth && picture.solid.empty())
        throw ParameterError("`earth` is drawn on a `solid`, which is not given");
}

SequenceParams RenderParams::files() const
{
    SequenceParams files = input;
    if (substeps > 1) files.frames.clear();
    return files;
}

void PictureParams::validate() const
{
    PictureParams copy = *this;
    checkLimits(parametersOf(copy));
    camera.validate();
    motion.validate();
    if (!lines.empty()) (void)FramePattern(lines);
    if (!solid.empty() && solid != "domain") (void)FramePattern(parseGridReference(solid).path.string());
    rays.validate();
    if (regionBox) {
        const auto& b = *regionBox;
        const bool isFinite = std::all_of(b.begin(), b.end(), [](double c) { return std::isfinite(c); });
        if (!isFinite || !(b[0] < b[3] && b[1] < b[4] && b[2] < b[5]))
            throw ParameterError(fmt::format("region box {} must be a low and a high corner", fmt::join(b, " ")));
    }
    if (std::min(size.x, size.y) < 1 || std::max(size.x, size.y) > kMostPixels)
        throw ParameterError(
            fmt::format("image size {}x{} must be 1 to {} pixels a side", size.x, size.y, kMostPixels));
}

double PictureSettings::imageBytes() const
{
    // The sum over the samples, one sample, the file's pixels, and the file.
    const double layerBytes = rays.layers ? 2 * sizeof(PixelLayers) : 0;
    const bool hasSurface = !solid.empty() || ground != GroundSide::kNone;
    const double surfaceBytes = hasSurface ? sizeof(float) + sizeof(glm::vec4) + sizeof(glm::vec3) : 0;
    const double partBytes = lines.empty() ? 0 : 2 * sizeof(float) + 1;
    // Two drawings of 32 bits, and both in linear light.
    const double annotationBytes = annotations.any() ? 2 * (sizeof(float) + sizeof(glm::vec4)) : 0;
    constexpr double kDisplayed = 3; // bytes
    const double perPixel =
        sizeof(glm::vec4) * 4 + layerBytes + surfaceBytes + partBytes + annotationBytes + kDisplayed;
    return double(size.x) * size.y * perPixel;
}

} // namespace vdblic
