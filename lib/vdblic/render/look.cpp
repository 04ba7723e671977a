#include "vdblic/render/look.h"

#include "vdblic/core/errors.h"

#include <cmath>

namespace vdblic {
namespace {

constexpr double kOpticalDepth = 3;
constexpr double kMostOpacity = 0.95; // of a voxel, chosen automatically

/// The shape of the automatic opacity: extinction over magnitude.
constexpr OpacityPoint kRise[] = {{0, 0}, {0.1, 0}, {0.25, 0.06}, {0.5, 0.3}, {0.75, 0.7}, {1, 1}};

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

TextureModulation stretch(std::vector<float> textures, double strength)
{
    const float low = percentile(textures, 0.1), high = percentile(textures, 0.98);
    // A texture of one value has no structure to show.
    if (!(low < high)) return {0, 1, 0};
    return {low, high, float(strength)};
}

std::vector<OpacityPoint> chooseOpacity(const TextureVolume::Samples& samples, double thickness,
                                        const TransferParams& transfer, std::array<double, 2> range,
                                        const TextureModulation& texture)
{
    std::vector<OpacityPoint> points(std::begin(kRise), std::end(kRise));
    const TransferFunction shape(transfer.colorMap, points, range);
    double sum = 0;
    for (std::size_t i = 0; i < samples.texture.size(); ++i) {
        const float density = texture.density(texture.stretched(broadcast8(samples.texture[i])))[0];
        const int entry = shape.entries(broadcast8(samples.magnitude[i]))[0];
        sum += double(density) * -std::expm1(-double(shape.table()[entry].extinction)); // the shape's own value
    }
    const double mean = sum / double(samples.texture.size());
    const double scale = mean > 0 ? kOpticalDepth / (mean * thickness) : 1;
    for (OpacityPoint& point : points)
        point.opacity = std::min(-std::expm1(-point.opacity * scale), kMostOpacity);
    return points;
}

} // namespace

void Shading::validate() const
{
    for (const float value : {ambient, diffuse, specular, shininess, leastGradient}) {
        if (!(value >= 0) || !std::isfinite(value)) {
            throw ParameterError(fmt::format("shading value {} must be a number not below 0", value));
        }
    }
}

void LookParams::validate() const
{
    transfer.validate();
    shading.validate();
    if (!(textureStrength >= 0 && textureStrength <= 1)) {
        throw ParameterError(fmt::format("texture strength {} must be between 0 and 1", textureStrength));
    }
}

bool Look::contributes(const LeafRange& range) const
{
    // Interpolation may round a little past its corners' values.
    const float highest = range.highTexture + 1e-5f * std::abs(range.highTexture);
    return transfer.contributes(range.lowMagnitude, range.highMagnitude) &&
           texture.density(texture.stretched(broadcast8(highest)))[0] > 0;
}

Look chooseLook(const LookParams& params, const TextureVolume& volume)
{
    params.validate();
    const TransferParams& transfer = params.transfer;
    const TextureVolume::Samples samples = volume.samples();
    if (samples.texture.empty()) throw InputError("no active voxel holds a finite number");
    const std::array<double, 2> range = transfer.range ? *transfer.range : magnitudeRange(samples.magnitude);
    const TextureModulation texture = stretch(samples.texture, params.textureStrength);
    const double thickness = std::cbrt(double(volume.domain().voxelCount()));
    std::vector<OpacityPoint> opacity = transfer.opacity;
    if (opacity.empty()) opacity = chooseOpacity(samples, thickness, transfer, range, texture);
    return {TransferFunction(transfer.colorMap, std::move(opacity), range), texture, params.shading};
}

} // namespace vdblic
