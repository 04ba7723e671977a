#include "vdblic/render/look.h"

#include "vdblic/core/errors.h"

#include <cmath>

namespace vdblic {
namespace {

constexpr double kMostOpacity = 0.95; // of a voxel, chosen automatically

// The automatic opacity has a point every tenth of the range.
constexpr int kPoints = 11;
constexpr double kSlow = 0.1;    // up to here along the range nothing shows
constexpr double kRarity = 1.2;  // 0: all magnitudes alike; 1: each magnitude in the same amount
constexpr double kRarest = 0.15; // of an equal share; rarer magnitudes gain no more

float percentile(std::vector<float>& values, double share)
{
    const auto place = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
    std::nth_element(values.begin(), place, values.end());
    return *place;
}

std::array<double, 2> magnitudeRange(std::vector<float> magnitudes)
{
    const double low = percentile(magnitudes, 0.02), high = percentile(magnitudes, 0.99);
    // Voxels that all flow alike are all at the top of the range; voxels at rest at its bottom.
    if (!(low < high)) return {0, high > 0 ? high : 1};
    return {low, high};
}

TextureModulation stretch(std::vector<float> textures, const LookParams& params)
{
    const float low = percentile(textures, 0.1), high = percentile(textures, 0.98);
    // A texture of one value has no structure to show.
    if (!(low < high)) return {0, 1, 0, 0};
    return {low, high, float(params.textureStrength), float(params.limbDarkening)};
}

/// Faster flow is more opaque, and so is flow of a rarer speed: what streams past everywhere must not hide the rest.
std::vector<OpacityPoint> chooseOpacity(const TextureVolume::Samples& samples, double voxelDepth,
                                        std::array<double, 2> range, const TextureModulation& texture)
{
    // How much texture there is at each point's magnitudes.
    std::array<double, kPoints> amounts{};
    double total = 0;
    for (std::size_t i = 0; i < samples.texture.size(); ++i) {
        const double position = (double(samples.magnitude[i]) - range[0]) / (range[1] - range[0]);
        const double density = double(texture.density(texture.stretched(broadcast8(samples.texture[i])))[0]);
        amounts[std::size_t(std::lround(std::clamp(position, 0.0, 1.0) * (kPoints - 1)))] += density;
        total += density;
    }
    std::vector<OpacityPoint> points(kPoints);
    double depth = 0; // of a voxel, on average
    for (int i = 0; i < kPoints; ++i) {
        const double position = double(i) / (kPoints - 1);
        const double share = std::max(amounts[i] / total * kPoints, kRarest);
        points[i] = {position, std::max(position - kSlow, 0.0) / std::pow(share, kRarity)};
        depth += points[i].opacity * amounts[i] / double(samples.texture.size());
    }
    const double scale = depth > 0 ? voxelDepth / depth : 1;
    for (OpacityPoint& point : points)
        point.opacity = std::min(-std::expm1(-point.opacity * scale), kMostOpacity);
    return points;
}

} // namespace

void LookParams::validate() const
{
    transfer.validate();
    shading.validate();
    const auto share = [](const char* name, double value) {
        if (!(value >= 0 && value <= 1)) {
            throw ParameterError(fmt::format("{} {} must be between 0 and 1", name, value));
        }
    };
    share("texture strength", textureStrength);
    share("limb darkening", limbDarkening);
    share("depth cue", depthCue);
    if (!(opticalDepth > 0) || !std::isfinite(opticalDepth)) {
        throw ParameterError(fmt::format("optical depth {} must be a number above 0", opticalDepth));
    }
    if (!(halo >= 0) || !std::isfinite(halo)) {
        throw ParameterError(fmt::format("halo strength {} must be a number not below 0", halo));
    }
}

bool Look::contributes(const LeafRange& range) const
{
    // Interpolation may round a little past its corners' values.
    const float highest = range.highTexture + 1e-5f * std::abs(range.highTexture);
    const Float8 stretched = texture.stretched(broadcast8(highest));
    return transfer.contributes(range.lowMagnitude, range.highMagnitude) &&
           (texture.density(stretched) + halo.density(texture, stretched))[0] > 0;
}

Look chooseLook(const LookParams& params, const TextureVolume::Samples& samples, double thickness)
{
    params.validate();
    if (samples.texture.empty()) throw InputError("no active voxel holds a finite number");
    TransferParams transfer = params.transfer;
    if (!transfer.range) transfer.range = magnitudeRange(samples.magnitude);
    const TextureModulation texture = stretch(samples.texture, params);
    if (transfer.opacity.empty()) {
        transfer.opacity = chooseOpacity(samples, params.opticalDepth / thickness, *transfer.range, texture);
    }
    return {.transfer = TransferFunction(transfer),
            .texture = texture,
            .shading = params.shading,
            .halo = {float(params.halo)},
            .depthCue = float(params.depthCue)};
}

Look chooseLook(const LookParams& params, const TextureVolume& volume)
{
    return chooseLook(params, volume.samples(), std::cbrt(double(volume.domain().voxelCount())));
}

} // namespace vdblic
