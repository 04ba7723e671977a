#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <cstddef>
#include <limits>
#include <vector>

namespace vdblic {

/// Means over the samples of a pixel's ray, weighted by each sample's share of the pixel's alpha.
struct PixelLayers {
    float depth = std::numeric_limits<float>::infinity(); ///< along the view axis [world]; infinite where alpha is 0
    glm::vec3 normal{0};                                  ///< world space, towards the eye, of length 1 or 0
    float driver = 0, texture = 0;                        ///< values of the grids; driver: the scalar that colours
    float samples = 0;                                    ///< number of samples along the ray
};

/// A picture: rows from the top, linear light, colours premultiplied by alpha.
struct Image {
    glm::ivec2 size{0, 0};
    std::vector<glm::vec4> pixels;        ///< size.x · size.y of them
    std::vector<PixelLayers> layers{};    ///< as many, or none
    std::vector<glm::vec4> annotations{}; ///< drawn over the picture; as many as pixels, or none

    [[nodiscard]] const glm::vec4& at(int x, int y) const { return pixels[std::size_t(y) * size.x + x]; }
};

} // namespace vdblic
