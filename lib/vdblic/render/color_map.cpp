#include "vdblic/render/color_map.h"

#include "vdblic/core/errors.h"

#include <fmt/ranges.h>
#include <glm/common.hpp>

#include <cmath>
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

struct NamedMap {
    const char* name;
    Stops stops;
};
constexpr NamedMap kMaps[] = {{"viridis", kViridis}, {"turbo", kTurbo}, {"coolwarm", kCoolwarm}, {"gray", kGray}};

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

glm::dvec3 colorMap(std::string_view name, double position)
{
    const auto* map =
        std::find_if(std::begin(kMaps), std::end(kMaps), [&](const NamedMap& m) { return m.name == name; });
    if (map == std::end(kMaps)) {
        throw ParameterError(
            fmt::format("no colour map '{}'; choose one of {}", name, fmt::join(colorMapNames(), ", ")));
    }
    const double place = std::clamp(position, 0.0, 1.0) * double(map->stops.size() - 1);
    const std::size_t stop = std::min(std::size_t(place), map->stops.size() - 2);
    return glm::mix(stopColor(map->stops[stop]), stopColor(map->stops[stop + 1]), place - double(stop));
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
