#pragma once

#include <glm/vec3.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

/// The names colorMap() knows.
[[nodiscard]] std::vector<std::string> colorMapNames();

/// A colour of a named map: `viridis`, `turbo`, `coolwarm` (Moreland 2009) or `gray`.
///
/// @param position 0 to 1; clamped
/// @return display (sRGB) values, 0 to 1; piecewise linear between the map's stops, which are evenly spaced
/// @throws ParameterError on an unknown name, listing the known ones
[[nodiscard]] glm::dvec3 colorMap(std::string_view name, double position);

/// Between display (sRGB) values and linear light, both 0 to 1 (IEC 61966-2-1).
[[nodiscard]] double linearFromDisplay(double value);
[[nodiscard]] double displayFromLinear(double value);
[[nodiscard]] glm::dvec3 linearFromDisplay(const glm::dvec3& color);

} // namespace vdblic
