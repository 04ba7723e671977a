#include "vdblic/image/whole_image.h"

#include "vdblic/image/image_file.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <png.h>

#include <cstddef>
#include <cstdint>
#include <exception>
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

bool isWholeImage(const std::filesystem::path& path)
{
    return imageFormat(path) == ImageFormat::kPng ? isWholePng(path) : isWholeExr(path);
}

} // namespace vdblic
