#include "vdblic/look/kinds.h"

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace vdblic {
namespace {

constexpr glm::dvec3 kNeutral(0.5, 0.53, 0.57);
/// Display (sRGB) values. The first ones differ in lightness too, for eyes that do not tell red from green.
constexpr std::array<glm::dvec3, 16> kColors{{{0.98, 0.55, 0.12},
                                              {0.24, 0.62, 1.00},
                                              {0.96, 0.88, 0.35},
                                              {0.85, 0.34, 0.72},
                                              {0.28, 0.78, 0.50},
                                              {0.92, 0.26, 0.26},
                                              {0.40, 0.88, 0.90},
                                              {0.56, 0.44, 0.95},
                                              {0.70, 0.46, 0.24},
                                              {0.72, 0.93, 0.40},
                                              {0.98, 0.68, 0.74},
                                              {0.18, 0.42, 0.70},
                                              {0.55, 0.60, 0.20},
                                              {0.64, 0.20, 0.44},
                                              {0.16, 0.55, 0.50},
                                              {0.80, 0.74, 0.98}}};

constexpr double kNoneShare = 0.12; ///< optical depth of unclassified voxels over that of a kind

} // namespace

void colorByKind(TransferParams& params)
{
    const std::size_t count = params.kinds.size();
    const std::array<double, 2> range{-0.5, double(count) - 0.5};
    if ((params.range && *params.range != range) || params.colorScale != ValueScale::kLinear) {
        params.kinds.clear();
        return;
    }
    params.range = range;
    const bool isDefault = params.colors.empty() && params.colorMap == TransferParams{}.colorMap;
    const std::vector<ColorPoint> given = params.colors.empty() ? colorMapPoints(params.colorMap) : params.colors;
    std::vector<ColorPoint> colors;
    for (std::size_t i = 0; i < count; ++i) {
        const double first = double(i) / double(count), last = double(i + 1) / double(count);
        const glm::dvec3 own = i == 0 ? kNeutral : kColors[(i - 1) % kColors.size()];
        const glm::dvec3 color = isDefault ? own : colorAt(given, (first + last) / 2);
        colors.insert(colors.end(), {{first, color}, {last, color}});
    }
    params.colors = std::move(colors);
}

std::vector<OpacityPoint> opacityOfKinds(const VolumeSamples& samples, double voxelDepth,
                                         const TextureModulation& texture, std::size_t kinds)
{
    // Sums of integers do not depend on the order of the samples.
    constexpr double kUnit = 0x1p32;
    std::uint64_t ofKinds = 0, ofNone = 0;
    for (std::size_t i = 0; i < samples.texture.size(); ++i) {
        const double density = double(texture.density(texture.stretched(broadcast8(samples.texture[i])))[0]);
        (samples.driver[i] > 0.5f ? ofKinds : ofNone) += std::uint64_t(density * kUnit);
    }
    const double mean = (double(ofKinds) + kNoneShare * double(ofNone)) / (kUnit * double(samples.texture.size()));
    const double depth = mean > 0 ? voxelDepth / mean : voxelDepth;
    const auto opacity = [](double opticalDepth) { return std::min(-std::expm1(-opticalDepth), kMostChosenOpacity); };
    const double end = 1 / double(kinds); // of the part of no kind
    return {{0, opacity(kNoneShare * depth)},
            {end, opacity(kNoneShare * depth)},
            {end, opacity(depth)},
            {1, opacity(depth)}};
}

} // namespace vdblic
