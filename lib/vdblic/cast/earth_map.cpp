#include "vdblic/cast/earth_map.h"

#include "vdblic/image/cairo_drawing.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>

namespace vdblic {
namespace {

constexpr int kWidth = 4096, kHeight = kWidth / 2; // pixels of the map, 10 km at the equator

// Closed outlines: the number of points, then longitude and latitude of each [0.01 degrees].
constexpr std::int16_t kOutlines[] = {
#include "vdblic/cast/land_outlines.inc"
};

/// How far a number of degrees is from the next whole multiple of a step.
double degreesFrom(double degrees, double step)
{
    return std::abs(degrees - std::round(degrees / step) * step);
}

} // namespace

EarthMap::EarthMap() : mLand(std::size_t(kWidth) * kHeight)
{
    const CairoCanvas canvas(CAIRO_FORMAT_A8, {kWidth, kHeight});
    cairo_t* const context = canvas.context();
    canvas.setColor(glm::dvec3(1));
    cairo_set_fill_rule(context, CAIRO_FILL_RULE_EVEN_ODD); // an outline in another is a lake
    constexpr double kPixels = kWidth / 36000.0;
    for (const std::int16_t* at = kOutlines; at != std::end(kOutlines);) {
        const std::int16_t* const end = at + 1 + 2 * *at;
        cairo_new_sub_path(context);
        for (++at; at != end; at += 2)
            cairo_line_to(context, (at[0] + 18000) * kPixels, (at[1] + 9000) * kPixels);
        cairo_close_path(context);
    }
    cairo_fill(context);
    cairo_surface_flush(canvas.surface());
    const unsigned char* const data = cairo_image_surface_get_data(canvas.surface());
    const int stride = cairo_image_surface_get_stride(canvas.surface());
    for (int row = 0; row < kHeight; ++row)
        std::copy_n(data + std::ptrdiff_t(row) * stride, kWidth, mLand.begin() + std::ptrdiff_t(row) * kWidth);
}

/// Linear between the middles of the map's pixels.
double EarthMap::land(double longitude, double latitude) const
{
    const double x = (longitude + 180) / 360 * kWidth - 0.5;
    const double y = std::clamp((latitude + 90) / 180 * kHeight - 0.5, 0.0, kHeight - 1.0);
    const double column = std::floor(x), row = std::min(std::floor(y), kHeight - 2.0);
    const auto at = [&](int right, int up) {
        const int across = (int(column) + right + kWidth) % kWidth;
        return double(mLand[(std::size_t(row) + std::size_t(up)) * kWidth + std::size_t(across)]) / 255;
    };
    return glm::mix(glm::mix(at(0, 0), at(1, 0), x - column), glm::mix(at(0, 1), at(1, 1), x - column), y - row);
}

glm::vec3 EarthMap::colored(const glm::vec3& color, const glm::dvec3& place, double pixel) const
{
    constexpr glm::dvec3 kLand(1), kSea(0.14, 0.2, 0.32); // factors on the light
    constexpr double kLine = 0.35;
    constexpr double kStep = 15, kPolarStep = 90, kPolar = 75; // degrees
    const double radius = glm::length(place);
    if (!(radius > 0)) return color;
    const double longitude = glm::degrees(std::atan2(place.y, place.x));
    const double latitude = glm::degrees(std::asin(std::clamp(place.z / radius, -1.0, 1.0)));
    const double across = radius * glm::radians(degreesFrom(latitude, kStep));
    const double along = std::hypot(place.x, place.y) *
                         glm::radians(degreesFrom(longitude, std::abs(latitude) > kPolar ? kPolarStep : kStep));
    const double line = std::clamp(1 - (std::min(across, along) / pixel - 0.5), 0.0, 1.0);
    return color * glm::vec3(glm::mix(kSea, kLand, land(longitude, latitude)) + kLine * line);
}

} // namespace vdblic
