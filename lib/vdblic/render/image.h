#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace vdblic {

/// What a pixel's ray met: means over its samples, weighted by what each contributes to the pixel's alpha.
struct PixelLayers {
    float depth = std::numeric_limits<float>::infinity(); ///< along the view axis [world]; infinite where alpha is 0
    glm::vec3 normal{0};                                  ///< world space, towards the eye, of length 1 or 0
    float magnitude = 0, texture = 0;                     ///< as the grids have them
    std::uint32_t samples = 0;                            ///< taken along the ray
};

/// A picture: rows from the top, linear light, colours premultiplied by alpha.
struct Image {
    glm::ivec2 size{0, 0};
    std::vector<glm::vec4> pixels;     ///< size.x · size.y of them
    std::vector<PixelLayers> layers{}; ///< as many, or none

    [[nodiscard]] const glm::vec4& at(int x, int y) const { return pixels[std::size_t(y) * size.x + x]; }
};

/// What an image file says about itself, by name. EXR only.
using ImageAttribute = std::variant<int, float, std::string, glm::vec2, glm::vec3>;
struct ImageHeader {
    std::vector<std::pair<std::string, ImageAttribute>> attributes;
    glm::mat4 worldToCamera{1}, worldToNdc{1}; ///< written as OpenEXR's standard attributes, as is
    float screenWindowWidth = 1;               ///< width of the picture at distance 1
};

enum class ImageFormat { kExr, kPng };

/// The format a file name's extension asks for. @throws ParameterError if it is neither .exr nor .png
[[nodiscard]] ImageFormat imageFormat(const std::filesystem::path& path);

/// A background as displayed (sRGB) with its own alpha, each 0 to 1.
struct Background {
    glm::dvec3 color{0.04, 0.05, 0.07};
    double alpha = 0;

    /// @throws ParameterError
    void validate() const;
};

/// The bytes of an .exr file: half RGBA, ZIP, over the background with its alpha.
[[nodiscard]] std::string encodeExr(const Image& image, const ImageHeader& header, const Background& background);
/// The bytes of a .png file: 8-bit sRGB, over the background's colour, opaque.
[[nodiscard]] std::string encodePng(const Image& image, const Background& background);

/// Write an image atomically in the format its name asks for.
/// @throws OutputError naming the file and the reason; a full disk is one
void writeImage(const std::filesystem::path& path, const Image& image, const ImageHeader& header,
                const Background& background);

} // namespace vdblic
