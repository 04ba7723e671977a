#include "vdblic/image/image_file.h"

#include "vdblic/core/errors.h"
#include "vdblic/image/color_map.h"
#include "vdblic/image/vector_text.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/output_pattern.h"

#include <fmt/format.h>
#include <glm/common.hpp>

#include <cctype>
#include <cstddef>
#include <string>

namespace vdblic {

ImageFormat imageFormat(const std::filesystem::path& path)
{
    checkExtension(path, {".exr", ".png"});
    return std::tolower(static_cast<unsigned char>(path.extension().string()[1])) == 'e' ? ImageFormat::kExr
                                                                                         : ImageFormat::kPng;
}

Parameters parametersOf(Background& params)
{
    const auto setColor = [&params](const Words& words) { params = {WordsOf<glm::dvec3>::read(words), 1, {}}; };
    const auto setTop = [&params](const Words& words) {
        params.top = WordsOf<glm::dvec3>::read(words);
        params.alpha = 1;
    };
    return {
        parameter("background", "Background as displayed; the look's by default.", WordType::kNumber, 3, setColor,
                  [&params] { return WordsOf<glm::dvec3>::write(params.color); },
                  {.words = "R G B", .group = "Picture", .limits = {0, 1}, .attribute = "backgroundColor"}),
        parameter("background_top",
                  "Background at the top of the picture, to which it changes evenly from `background` at the bottom.",
                  WordType::kNumber, 3, setTop,
                  [&params] { return WordsOf<std::optional<glm::dvec3>>::write(params.top); },
                  {.words = "R G B", .group = "Picture", .limits = {0, 1}}),
        parameter("background_alpha",
                  "How opaque the background is in .exr; by default 1 if a background is given, else 0.", params.alpha,
                  {.group = "Picture", .limits = {0, 1}}),
    };
}

glm::dvec3 Background::at(double down) const
{
    return top ? glm::mix(*top, color, down) : color;
}

std::vector<glm::vec3> Background::rows(int count) const
{
    std::vector<glm::vec3> result;
    for (int y = 0; y < count; ++y)
        result.emplace_back(linearFromDisplay(at((y + 0.5) / count)));
    return result;
}

std::vector<glm::vec4> pixelsOver(const Image& image, const Background& background)
{
    const std::vector<glm::vec3> rows = background.rows(image.size.y);
    std::vector<glm::vec4> pixels = image.pixels;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        const glm::vec4 behind = glm::vec4(rows[i / std::size_t(image.size.x)], 1) * float(background.alpha);
        pixels[i] += behind * (1 - pixels[i].a);
    }
    return pixels;
}

void Background::validate() const
{
    Background copy = *this;
    checkLimits(parametersOf(copy));
}

void writeImage(const std::filesystem::path& path, const Image& image, const ImageHeader& header,
                const Background& background, const ExrParams& params)
{
    writeTextFile(path, imageFormat(path) == ImageFormat::kPng ? encodePng(image, background)
                                                               : encodeExr(image, header, background, params));
}

} // namespace vdblic
