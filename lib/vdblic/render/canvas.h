#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cstdint>
#include <string_view>
#include <vector>

namespace vdblic {

/// An opaque picture to draw plots on; places in pixels from the top left, colours as displayed (sRGB), 0 to 1.
class Canvas {
  public:
    Canvas(const glm::ivec2& size, const glm::dvec3& color);

    /// Fill a rectangle; pixels it covers in part are mixed.
    void rectangle(const glm::dvec2& low, const glm::dvec2& high, const glm::dvec3& color);
    /// A line with round ends.
    void line(const glm::dvec2& from, const glm::dvec2& to, double width, const glm::dvec3& color);
    /// Write lower case letters, digits and + - . / % ( ) [ ]; anything else is a gap.
    /// @param place  of the baseline's point that `anchor` tells: 0 the text's begin, ½ its middle, 1 its end
    void text(const glm::dvec2& place, double anchor, std::string_view what, const glm::dvec3& color);

    [[nodiscard]] const glm::ivec2& size() const { return mSize; }
    /// Red, green and blue of each pixel, rows from the top.
    [[nodiscard]] const std::vector<std::uint8_t>& bytes() const { return mBytes; }

  private:
    void mix(int x, int y, const glm::dvec3& color, double share);

    glm::ivec2 mSize;
    std::vector<std::uint8_t> mBytes;
};

} // namespace vdblic
