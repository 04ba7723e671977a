#include "vdblic/image/image_file.h"

#include "vdblic/core/errors.h"
#include "vdblic/image/color_map.h"
#include "vdblic/image/vector_text.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/output_pattern.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/vec4.hpp>
#include <png.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <string>
#include <vector>

namespace vdblic {
namespace {

bool isWholeExr(const std::filesystem::path& path)
{
    constexpr std::int64_t kMostWidth = 1 << 20;
    try {
        constexpr int kNoThreads = 0; // all rows are read into the same place
        Imf::InputFile file(path.c_str(), kNoThreads);
        const Imath::Box2i window = file.header().dataWindow();
        const std::int64_t width = std::int64_t(window.max.x) - window.min.x + 1;
        const Imf::ChannelList& channels = file.header().channels();
        if (width < 1 || width > kMostWidth || channels.begin() == channels.end()) return false;
        std::vector<float> row(std::size_t(width), 0.0f);
        char* const first = reinterpret_cast<char*>(row.data()) - std::ptrdiff_t(sizeof(float)) * window.min.x;
        Imf::FrameBuffer pixels;
        pixels.insert(channels.begin().name(), Imf::Slice(Imf::FLOAT, first, sizeof(float), 0));
        file.setFrameBuffer(pixels);
        file.readPixels(window.min.y, window.max.y);
        return file.isComplete();
    } catch (const std::exception&) {
        return false;
    }
}

bool isWholePng(const std::filesystem::path& path)
{
    constexpr std::uint64_t kMostPixels = std::uint64_t(1) << 28;
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    if (!png_image_begin_read_from_file(&png, path.c_str())) return false;
    png.format = PNG_FORMAT_GRAY;
    if (std::uint64_t(png.width) * png.height > kMostPixels) {
        png_image_free(&png);
        return false;
    }
    std::vector<png_byte> pixels(PNG_IMAGE_SIZE(png));
    const png_color black{};
    return png_image_finish_read(&png, &black, pixels.data(), 0, nullptr) != 0;
}

} // namespace

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
                  [&params] { return WordsOf<glm::dvec3>::write(params.color); }, {.words = "R G B", .limits = {0, 1}}),
        parameter("background_top",
                  "Background at the top of the picture, to which it changes evenly from `background` at the bottom.",
                  WordType::kNumber, 3, setTop,
                  [&params] { return WordsOf<std::optional<glm::dvec3>>::write(params.top); },
                  {.words = "R G B", .limits = {0, 1}}),
        parameter("background_alpha",
                  "How opaque the background is in .exr; by default 1 if a background is given, else 0.", params.alpha,
                  {.limits = {0, 1}}),
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

bool isWholeImage(const std::filesystem::path& path)
{
    return imageFormat(path) == ImageFormat::kPng ? isWholePng(path) : isWholeExr(path);
}

Image exposed(Image image, double stops)
{
    if (stops == 0) return image;
    const auto gain = float(std::exp2(stops));
    for (glm::vec4& pixel : image.pixels)
        pixel = glm::vec4(glm::vec3(pixel) * gain, pixel.a);
    return image;
}

glm::vec3 toneMapped(const glm::vec3& light, float knee)
{
    constexpr float kFading = 0.15f;
    const float most = std::max({light.r, light.g, light.b});
    if (!(most > knee)) return light;
    const float room = 1 - knee;
    const float shown = 1 - room * room / (most - knee + room);
    const float white = 1 - 1 / (kFading * (most - shown) + 1);
    return glm::mix(light * (shown / most), glm::vec3(shown), white);
}

} // namespace vdblic
