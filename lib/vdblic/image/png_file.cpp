#include "vdblic/core/errors.h"
#include "vdblic/image/color_map.h"
#include "vdblic/image/image_file.h"

#include <fmt/format.h>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <png.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace vdblic {
namespace {

/// @param bytes as displayBytes() returns them
std::string encodeRgb(const glm::ivec2& imageSize, const std::string& bytes)
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

std::string displayBytes(const Image& image, const Background& background)
{
    const std::vector<glm::vec3> rows = background.rows(image.size.y);
    float knee = kToneKnee;
    for (const glm::vec3& row : rows)
        knee = std::max({knee, row.r, row.g, row.b});
    std::string bytes(image.pixels.size() * 3, '\0');
    tbb::parallel_for(std::size_t(0), image.pixels.size(), [&](std::size_t i) {
        const glm::vec3 behind = rows[i / std::size_t(image.size.x)] * (1 - image.pixels[i].a);
        glm::vec4 pixel(toneMapped(glm::vec3(image.pixels[i]) + behind, knee), 1);
        if (!image.annotations.empty()) pixel = image.annotations[i] + pixel * (1 - image.annotations[i].a);
        for (int channel = 0; channel < 3; ++channel) {
            const double value = displayFromLinear(std::clamp(double(pixel[channel]), 0.0, 1.0));
            bytes[3 * i + std::size_t(channel)] = char(std::lround(value * 255));
        }
    });
    return bytes;
}

std::string encodePng(const Image& image, const Background& background)
{
    return encodeRgb(image.size, displayBytes(image, background));
}

} // namespace vdblic
