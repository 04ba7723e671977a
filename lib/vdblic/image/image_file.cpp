#include "vdblic/image/image_file.h"

#include "vdblic/core/errors.h"
#include "vdblic/image/color_map.h"
#include "vdblic/image/vector_text.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/output_pattern.h"

#include <fmt/format.h>

#include <cctype>
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
    const auto setColor = [&params](const Words& words) { params = {WordsOf<glm::dvec3>::read(words), 1}; };
    return {
        parameter("background", "Background as displayed; the look's by default.", WordType::kNumber, 3, setColor,
                  [&params] { return WordsOf<glm::dvec3>::write(params.color); },
                  {.words = "R G B", .group = "Picture", .limits = {0, 1}, .attribute = "backgroundColor"}),
        parameter("background_alpha",
                  "How opaque the background is in .exr; by default 1 if a background is given, else 0.", params.alpha,
                  {.group = "Picture", .limits = {0, 1}}),
    };
}

glm::vec4 Background::light() const
{
    return glm::vec4(glm::vec3(linearFromDisplay(color)), 1) * float(alpha);
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
