#include "vdblic/render/render_params.h"

#include "vdblic/cast/supersampling.h"
#include "vdblic/core/errors.h"
#include "vdblic/look/histogram.h"

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

} // namespace

void RenderParams::validate() const
{
    if (output.empty() && film.empty() && histogram.empty() && transferOut.empty())
        throw ParameterError("there is nothing to make: give an output");
    if (!film.empty() && std::filesystem::path(film).extension() != ".mp4")
        throw ParameterError(fmt::format("film '{}' must end in .mp4", film));
    if (!film.empty() && skipExisting)
        throw ParameterError("a film needs the pictures of all frames; existing ones cannot be skipped");
    if (!(framesPerSecond >= 0.01 && framesPerSecond <= 1000)) {
        throw ParameterError(fmt::format("{} frames per second must be between 0.01 and 1000", framesPerSecond));
    }
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
    camera.validate();
    motion.validate();
    look.validate();
    solid.validate();
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
    for (const double factor : {stretch.x, stretch.y, stretch.z}) {
        if (!(factor >= 1 / kMostStretch && factor <= kMostStretch)) {
            throw ParameterError(
                fmt::format("stretch {} must be between {} and {}", factor, 1 / kMostStretch, kMostStretch));
        }
    }
    if (!(scale > 0 && scale <= kMostPixels)) {
        throw ParameterError(fmt::format("scale {} must be above 0 and at most {}", scale, kMostPixels));
    }
    for (const glm::ivec2& sides : {size, scaledSize()}) {
        if (std::min(sides.x, sides.y) >= 1 && std::max(sides.x, sides.y) <= kMostPixels) continue;
        throw ParameterError(
            fmt::format("image size {}x{} must be 1 to {} pixels a side", sides.x, sides.y, kMostPixels));
    }
    if (samples < 1 || samples > kMostSamples) {
        throw ParameterError(fmt::format("{} samples to a pixel must be 1 to {}", samples, kMostSamples));
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
    const double solidBytes = solid.source.empty() ? 0 : sizeof(float) + 2 * sizeof(glm::vec3);
    // Two drawings of 32 bits, and both in linear light.
    const double annotationBytes = annotations.any() ? 2 * (sizeof(float) + sizeof(glm::vec4)) : 0;
    const double perPixel = sizeof(glm::vec4) * 4 + layerBytes + solidBytes + annotationBytes + (film.empty() ? 0 : 3);
    return double(scaledSize().x) * scaledSize().y * perPixel;
}

} // namespace vdblic
