#include "vdblic/image/color_map.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <span>

namespace vdblic {
namespace {

using Stops = std::span<const unsigned>; // 0xRRGGBB

constexpr unsigned kViridis[] = {0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c,
                                 0x28ae80, 0x5ec962, 0xaddc30, 0xfde725};
constexpr unsigned kTurbo[] = {0x30123b, 0x4145ab, 0x4675ed, 0x39a2fc, 0x1bcfd4, 0x24eca6, 0x61fc6c, 0xa4fc3b,
                               0xd1e834, 0xf3c63a, 0xfe9b2d, 0xf36315, 0xd93806, 0xb11901, 0x7a0402};
constexpr unsigned kCoolwarm[] = {0x3b4cc0, 0x6282ea, 0x8db0fe, 0xb8d0f9, 0xdddddd,
                                  0xf5c4ad, 0xf49a7b, 0xde604d, 0xb40426};
constexpr unsigned kGray[] = {0x000000, 0xffffff};
constexpr unsigned kInk[] = {0x7d8aa5, 0x44546f, 0x1c2a44, 0x0b1226};
constexpr unsigned kIce[] = {0x16324f, 0x2f6f9f, 0x6fb3d9, 0xc4e6f5, 0xffffff};
constexpr unsigned kEmber[] = {0x3f3fa0, 0x7d46a8, 0xb94f96, 0xe4646f, 0xf68a4e, 0xfcb945, 0xfbe77a, 0xfffbe0};
constexpr unsigned kFire[] = {0x2a0a0a, 0x8c1c0c, 0xe2581a, 0xfcb53b, 0xfff6d5};

struct NamedMap {
    const char* name;
    Stops stops;
};
constexpr NamedMap kMaps[] = {{"ember", kEmber},       {"viridis", kViridis}, {"turbo", kTurbo}, {"fire", kFire},
                              {"coolwarm", kCoolwarm}, {"gray", kGray},       {"ink", kInk},     {"ice", kIce}};

glm::dvec3 stopColor(unsigned stop)
{
    return glm::dvec3(stop >> 16, stop >> 8 & 255, stop & 255) / 255.0;
}

} // namespace

std::vector<std::string> colorMapNames()
{
    std::vector<std::string> names;
    for (const NamedMap& map : kMaps)
        names.emplace_back(map.name);
    return names;
}

std::vector<ColorPoint> colorMapPoints(std::string_view name)
{
    const auto* map =
        std::find_if(std::begin(kMaps), std::end(kMaps), [&](const NamedMap& m) { return m.name == name; });
    if (map == std::end(kMaps)) {
        throw ParameterError(
            fmt::format("no colour map '{}'; choose one of {}", name, fmt::join(colorMapNames(), ", ")));
    }
    std::vector<ColorPoint> points;
    for (std::size_t i = 0; i < map->stops.size(); ++i)
        points.push_back({double(i) / double(map->stops.size() - 1), stopColor(map->stops[i])});
    return points;
}

glm::dvec3 colorAt(const std::vector<ColorPoint>& points, double position)
{
    const auto after = std::upper_bound(points.begin(), points.end(), position,
                                        [](double p, const ColorPoint& point) { return p < point.position; });
    if (after == points.begin()) return after->color;
    const auto before = std::prev(after);
    if (after == points.end()) return before->color;
    return glm::mix(before->color, after->color, (position - before->position) / (after->position - before->position));
}

glm::dvec3 colorMap(std::string_view name, double position)
{
    return colorAt(colorMapPoints(name), position);
}

double linearFromDisplay(double value)
{
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

double displayFromLinear(double value)
{
    return value <= 0.0031308 ? value * 12.92 : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
}

glm::dvec3 linearFromDisplay(const glm::dvec3& color)
{
    return {linearFromDisplay(color.x), linearFromDisplay(color.y), linearFromDisplay(color.z)};
}

} // namespace vdblic
