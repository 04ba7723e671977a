#pragma once

#include <glm/vec3.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

/// The names colorMap() knows.
[[nodiscard]] std::vector<std::string> colorMapNames();

/// A colour of a named map: `ember`, `viridis`, `turbo`, `fire`, `coolwarm` (Moreland 2009), `gray`, `ink` or `ice`.
/// Lightness rises evenly along `ember` and `viridis`, for eyes that do not tell red from green too.
///
/// @param position 0 to 1; clamped
/// @return display (sRGB) values, 0 to 1; piecewise linear between the map's stops, which are evenly spaced
/// @throws ParameterError on an unknown name, listing the known ones
[[nodiscard]] glm::dvec3 colorMap(std::string_view name, double position);

/// A corner of a piecewise linear colour curve.
struct ColorPoint {
    double position;  ///< 0 to 1
    glm::dvec3 color; ///< display (sRGB) values, 0 to 1
};

/// A named map's stops. @throws ParameterError on an unknown name, listing the known ones
[[nodiscard]] std::vector<ColorPoint> colorMapPoints(std::string_view name);
/// The colour at a position; constant before the first point and after the last. @param points not empty, rising
[[nodiscard]] glm::dvec3 colorAt(const std::vector<ColorPoint>& points, double position);

/// Between display (sRGB) values and linear light, both 0 to 1 (IEC 61966-2-1).
[[nodiscard]] double linearFromDisplay(double value);
[[nodiscard]] double displayFromLinear(double value);
[[nodiscard]] glm::dvec3 linearFromDisplay(const glm::dvec3& color);

} // namespace vdblic
