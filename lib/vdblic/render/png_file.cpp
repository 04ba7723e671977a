#include "vdblic/core/errors.h"
#include "vdblic/render/color_map.h"
#include "vdblic/render/image_file.h"

#include <fmt/format.h>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace vdblic {
namespace {

/// @param bytes red, green and blue of each pixel, rows from the top
std::string encodeRgb(const glm::ivec2& imageSize, const std::vector<std::uint8_t>& bytes)
{
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = unsigned(imageSize.x);
    png.height = unsigned(imageSize.y);
    png.format = PNG_FORMAT_RGB;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    std::string result(size, '\0');
    if (!png_image_write_to_memory(&png, result.data(), &size, 0, bytes.data(), 0, nullptr)) {
        throw OutputError(fmt::format("an image of {}x{} pixels cannot be encoded as PNG: {}", imageSize.x, imageSize.y,
                                      png.message));
    }
    result.resize(size);
    return result;
}

} // namespace

std::string encodePng(const Image& image, const Background& background)
{
    const glm::vec4 back(linearFromDisplay(background.color), 1);
    std::vector<std::uint8_t> bytes;
    bytes.reserve(image.pixels.size() * 3);
    for (const glm::vec4& front : image.pixels) {
        const glm::vec4 pixel = front + back * (1 - front.a);
        for (int channel = 0; channel < 3; ++channel) {
            const double value = displayFromLinear(std::clamp(double(pixel[channel]), 0.0, 1.0));
            bytes.push_back(std::uint8_t(std::lround(value * 255)));
        }
    }
    return encodeRgb(image.size, bytes);
}

} // namespace vdblic
