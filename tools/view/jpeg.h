#pragma once

#include <glm/vec2.hpp>

#include <string>
#include <string_view>

namespace vdblic::view {

/// The bytes of a JPEG file.
/// @param pixels  red, green and blue of each pixel, rows from the top
/// @param quality 1 to 100; colours are halved in resolution below 90
[[nodiscard]] std::string encodeJpeg(std::string_view pixels, const glm::ivec2& size, int quality);

} // namespace vdblic::view
