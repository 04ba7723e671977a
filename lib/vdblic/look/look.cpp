#include "vdblic/look/look.h"

#include "vdblic/core/errors.h"
#include "vdblic/look/kinds.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <vector>

namespace vdblic {
namespace {

constexpr double kMostRatio = 1e4; // of the ends of a logarithmic range, where chosen automatically

// The automatic opacity has a point every tenth of the range.
constexpr int kPoints = 11;
constexpr double kSlow = 0.1;      // positions up to this are transparent
constexpr double kRarity = 1.2;    // 0: frequency does not count; 1: opacity is inverse to frequency
constexpr double kRarest = 0.15;   // least frequency that counts, in equal shares
constexpr double kFaintest = 0.25; // optical depth of moving voxels of one value alone, of that of the whole
constexpr double kStill = 0.1;     // part of the values, from the still ones on, over which it rises to that

float percentile(std::vector<float>& values, double share)
{
    const auto found = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
    std::nth_element(values.begin(), found, values.end());
    return *found + 0.0f; // of the two zeros the one above
}

std::array<double, 2> rangeOf(std::vector<float> drivers, ValueScale scale)
{
    const bool isLog = scale == ValueScale::kLogarithmic;
    if (isLog) {
        std::erase_if(drivers, [](float value) { return !(value >= float(ScalarAxis::kLeastValue)); });
        if (drivers.empty()) {
            throw InputError(fmt::format("a logarithmic scale shows values of {} or more, and there is none; make "
                                         "`color_scale` or `opacity_scale` linear",
                                         ScalarAxis::kLeastValue));
        }
    }
    const double low = percentile(drivers, 0.02), high = percentile(drivers, 0.99);
    if (!(std::max(std::abs(low), std::abs(high)) <= ScalarAxis::kMostValue)) {
        throw InputError(
            fmt::format("the values {} to {} are too large to be shown; give smaller ones with `range`", low, high));
    }
    // A driver of one value is at the top of the range, or at its bottom if it is 0.
    if (!(low < high)) return {isLog ? high / 10 : 0, high > 0 ? high : 1};
    return {isLog ? std::max(low, high / kMostRatio) : low, high};
}

/// Opacity follows a scalar of both signs, such as q, from 0 on.
std::array<double, 2> opacityRangeOf(const std::vector<float>& drivers, ValueScale scale)
{
    const auto [low, high] = rangeOf(drivers, scale);
    return {low < 0 && high > 0 ? 0 : low, high};
}

/// Colours of the samples that are not transparent; all colours if all samples are.
std::vector<float> colorsSeen(const VolumeSamples& samples, const TransferParams& params)
{
    const TransferFunction transfer(params);
    std::vector<float> colors;
    for (std::size_t i = 0; i < samples.color.size(); ++i) {
        const double position = transfer.opacityAxis().position(double(samples.driver[i]));
        if (transfer.opacityAt(std::clamp(position, 0.0, 1.0)) > 0) colors.push_back(samples.color[i]);
    }
    return colors.empty() ? samples.color : colors;
}

TextureModulation stretch(std::vector<float> textures, const LookParams& params)
{
    const float low = percentile(textures, 0.1), high = percentile(textures, 0.98);
    // A texture of one value has no structure.
    if (!(low < high)) return {0, 1, 0, 0};
    return {low, high, float(params.textureStrength), float(params.limbDarkening)};
}

/// Opacity rises with the driver and with the rarity of its value: common values would hide the others. The order of
/// the samples does not matter: sums are of integers.
/// @param still up to this value there is nothing to see; values well above it are to be seen, however common they are.
/// Nothing: they need not be
std::vector<OpacityPoint> chooseOpacity(const VolumeSamples& samples, double voxelDepth, const ScalarAxis& axis,
                                        const TextureModulation& texture, std::optional<double> still)
{
    // Amount of texture near each point.
    constexpr double kUnit = 0x1p32;
    std::array<std::uint64_t, kPoints> amounts{};
    std::uint64_t total = 0;
    for (std::size_t i = 0; i < samples.texture.size(); ++i) {
        const double position = axis.position(double(samples.driver[i]));
        const double density = double(texture.density(texture.stretched(broadcast8(samples.texture[i])))[0]);
        const auto amount = std::uint64_t(density * kUnit);
        amounts[std::size_t(std::lround(std::clamp(position, 0.0, 1.0) * (kPoints - 1)))] += amount;
        total += amount;
    }
    std::vector<OpacityPoint> points(kPoints);
    double depth = 0; // mean optical depth of a voxel
    for (int i = 0; i < kPoints; ++i) {
        const double position = double(i) / (kPoints - 1);
        const double share = std::max(double(amounts[i]) / double(total) * kPoints, kRarest);
        points[i] = {position, std::max(position - kSlow, 0.0) / std::pow(share, kRarity)};
        depth += points[i].opacity * double(amounts[i]) / (kUnit * double(samples.texture.size()));
    }
    const double scale = depth > 0 ? voxelDepth / depth : 1;
    const double full = double(total) / (kUnit * double(samples.texture.size())); // mean density of the texture
    for (OpacityPoint& point : points) {
        double least = 0;
        if (still && full > 0) {
            const double above = (axis.value(point.position) - *still) / (axis.range[1] - *still);
            least = kFaintest * std::clamp(above / kStill, 0.0, 1.0) * voxelDepth / full;
        }
        point.opacity = std::min(-std::expm1(-std::max(point.opacity * scale, least)), kMostChosenOpacity);
    }
    return points;
}

/// The share of their colour's light that two thirds of the visible voxels exceed: an estimate from the texture's part
/// in the colour, the lights on surfaces in all directions, and shadows.
double lightShare(const Look& look, const VolumeSamples& samples)
{
    constexpr double kArriving = 0.35; // of the light in shadows, in the mean
    constexpr double kFacing = 0.5;    // mean cosine between a light and normals in all directions
    constexpr double kSurface = 0.7;   // share of samples that are lit as a surface
    constexpr int kSteps = 256;
    constexpr double kUnit = 0x1p32; // sums of integers do not depend on the order of the samples
    std::array<std::uint64_t, kSteps> visible{};
    for (std::size_t i = 0; i < samples.texture.size(); ++i) {
        const Float8 stretched = look.texture.stretched(broadcast8(samples.texture[i]));
        const int entry = look.transfer.entries(broadcast8(samples.driver[i]))[0];
        const double extinction =
            double(look.transfer.extinctions()[entry]) * double(look.texture.density(stretched)[0]);
        visible[std::size_t(look.texture.brightness(stretched)[0] * (kSteps - 1))] +=
            std::uint64_t(std::min(extinction, 1.0) * kUnit);
    }
    const std::uint64_t all = std::accumulate(visible.begin(), visible.end(), std::uint64_t(0));
    if (all == 0) return 1;
    std::uint64_t darker = 0;
    int third = 0;
    while (third < kSteps - 1 && (darker += visible[std::size_t(third)]) < all / 3)
        ++third;
    const Shading& shading = look.shading;
    auto light = double(shading.headLight);
    for (const DirectionalLight& distant : shading.lights)
        light += distant.intensity;
    const double full = double(shading.ambient) + double(shading.diffuse) * kFacing * light;
    const double lit = shading.model == ShadingModel::kNone      ? 1
                       : shading.model == ShadingModel::kSurface ? 1 + kSurface * (full - 1)
                                                                 : full;
    return (third + 0.5) / kSteps * lit * (1 - double(look.shadows) * (1 - kArriving));
}

/// Stops that make a share of the light the whole, in tenths; never fewer than none.
double exposureFor(double share)
{
    constexpr double kMost = 3;
    return std::round(10 * std::clamp(-std::log2(share), 0.0, kMost)) / 10;
}

} // namespace

std::vector<glm::vec3> Look::backgroundRows(int count) const
{
    std::vector<glm::vec3> rows = background.rows(count);
    for (glm::vec3& row : rows)
        row *= float(std::exp2(-exposure));
    return rows;
}

bool Look::contributes(const LeafRange& range) const
{
    // Interpolation may round past its corners' values.
    const float highest = range.highTexture + 1e-5f * std::abs(range.highTexture);
    const Float8 stretched = texture.stretched(broadcast8(highest));
    return transfer.contributes(range.lowDriver, range.highDriver) &&
           (texture.density(stretched) + halo.density(texture, stretched))[0] > 0;
}

Look chooseLook(const LookParams& params, const VolumeSamples& samples, double thickness, bool ofLines)
{
    params.validate();
    if (samples.texture.empty())
        throw InputError("no active voxel that is shown holds a finite number; check the grid, `roi` and `roi_box`");
    TransferParams transfer = params.transfer;
    const bool one = samples.color.empty();
    if (!transfer.kinds.empty()) colorByKind(transfer);
    const ValueScale opacityScale = transfer.opacityScale.value_or(one ? transfer.colorScale : ValueScale::kLinear);
    // Values below a given range are hidden.
    std::optional<double> still;
    if (one) still = transfer.range ? (*transfer.range)[0] : 0;
    if (!transfer.range) transfer.range = rangeOf(one ? samples.driver : samples.color, transfer.colorScale);
    if (!one && !transfer.opacityRange) transfer.opacityRange = opacityRangeOf(samples.driver, opacityScale);
    const TextureModulation texture =
        ofLines ? TextureModulation{.limbDarkening = 0, .foot = 0} : stretch(samples.texture, params);
    const double voxelDepth = params.opticalDepth / thickness;
    if (transfer.opacity.empty() && one && !transfer.kinds.empty()) {
        transfer.opacity = opacityOfKinds(samples, voxelDepth, texture, transfer.kinds.size());
    } else if (transfer.opacity.empty()) {
        transfer.opacity = chooseOpacity(
            samples, voxelDepth, {transfer.opacityRange.value_or(*transfer.range), opacityScale}, texture, still);
    }
    if (!one && !params.transfer.range) transfer.range = rangeOf(colorsSeen(samples, transfer), transfer.colorScale);
    Look look{.transfer = TransferFunction(transfer),
              .texture = texture,
              .shading = params.shading,
              .halo = {float(params.halo)},
              .depthCue = float(params.depthCue),
              .shadows = float(params.shadows),
              .occlusion = float(params.occlusion)};
    look.exposure = params.exposure ? *params.exposure : exposureFor(lightShare(look, samples));
    return look;
}

} // namespace vdblic
