#include "vdblic/render/image.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/version.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/render/color_map.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfVecAttribute.h>
#include <png.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <system_error>

namespace vdblic {
namespace {

/// A file in memory, so that one place writes to disk and checks it.
class MemoryStream : public Imf::OStream {
  public:
    MemoryStream() : Imf::OStream("memory") {}

    void write(const char bytes[], int count) override
    {
        if (mPlace + std::size_t(count) > mBytes.size()) mBytes.resize(mPlace + std::size_t(count));
        std::memcpy(mBytes.data() + mPlace, bytes, std::size_t(count));
        mPlace += std::size_t(count);
    }
    std::uint64_t tellp() override { return mPlace; }
    void seekp(std::uint64_t place) override { mPlace = place; }

    [[nodiscard]] std::string take() { return std::move(mBytes); }

  private:
    std::string mBytes;
    std::size_t mPlace = 0;
};

/// GLM's columns are Imath's rows, for Imath multiplies row vectors from the left.
Imath::M44f imathMatrix(const glm::mat4& m)
{
    Imath::M44f result;
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j)
            result[i][j] = m[i][j];
    }
    return result;
}

struct InsertAttribute {
    Imf::Header& header;
    const std::string& name;

    void operator()(int value) const { header.insert(name, Imf::IntAttribute(value)); }
    void operator()(float value) const { header.insert(name, Imf::FloatAttribute(value)); }
    void operator()(const std::string& value) const { header.insert(name, Imf::StringAttribute(value)); }
    void operator()(const glm::vec2& v) const { header.insert(name, Imf::V2fAttribute({v.x, v.y})); }
    void operator()(const glm::vec3& v) const { header.insert(name, Imf::V3fAttribute({v.x, v.y, v.z})); }
};

glm::vec4 over(const glm::vec4& front, const glm::vec4& back)
{
    return front + back * (1 - front.a);
}

void writeBytes(const std::filesystem::path& path, const std::string& bytes)
{
    AtomicFile output(path);
    errno = 0;
    std::ofstream stream(output.temporary(), std::ios::binary | std::ios::trunc);
    stream.write(bytes.data(), std::streamsize(bytes.size()));
    stream.close();
    if (!stream) {
        throw OutputError(
            fmt::format("{}: cannot be written: {}", path.string(), std::generic_category().message(errno)));
    }
    output.commit();
}

} // namespace

ImageFormat imageFormat(const std::filesystem::path& path)
{
    const std::string extension = path.extension().string();
    if (extension == ".exr") return ImageFormat::kExr;
    if (extension == ".png") return ImageFormat::kPng;
    throw ParameterError(fmt::format("output '{}' must end in .exr or .png", path.string()));
}

void Background::validate() const
{
    for (const double value : {color.r, color.g, color.b, alpha}) {
        if (!(value >= 0 && value <= 1))
            throw ParameterError(fmt::format("background value {} must be between 0 and 1", value));
    }
}

std::string encodeExr(const Image& image, const ImageHeader& header, const Background& background)
{
    Imf::Header exr(image.size.x, image.size.y, 1, {0, 0}, header.screenWindowWidth, Imf::INCREASING_Y,
                    Imf::ZIP_COMPRESSION);
    Imf::addWorldToCamera(exr, imathMatrix(header.worldToCamera));
    Imf::addWorldToNDC(exr, imathMatrix(header.worldToNdc));
    exr.insert("creator", Imf::StringAttribute(kCreator));
    for (const auto& [name, value] : header.attributes)
        std::visit(InsertAttribute{exr, name}, value);

    using Pixel = std::array<Imath::half, 4>;
    std::vector<Pixel> pixels(image.pixels.size());
    const glm::vec4 back = glm::vec4(glm::vec3(linearFromDisplay(background.color)), 1) * float(background.alpha);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        const glm::vec4 pixel = over(image.pixels[i], back);
        pixels[i] = {pixel.r, pixel.g, pixel.b, pixel.a};
    }
    Imf::FrameBuffer frame;
    constexpr const char* kChannels[] = {"R", "G", "B", "A"};
    for (std::size_t channel = 0; channel < 4; ++channel) {
        exr.channels().insert(kChannels[channel], Imf::Channel(Imf::HALF));
        frame.insert(kChannels[channel], Imf::Slice(Imf::HALF, reinterpret_cast<char*>(&pixels[0][channel]),
                                                    sizeof(Pixel), sizeof(Pixel) * std::size_t(image.size.x)));
    }
    MemoryStream stream;
    {
        Imf::OutputFile file(stream, exr);
        file.setFrameBuffer(frame);
        file.writePixels(image.size.y);
    }
    return stream.take();
}

std::string encodePng(const Image& image, const Background& background)
{
    const glm::vec4 back(linearFromDisplay(background.color), 1);
    std::vector<png_byte> bytes;
    bytes.reserve(image.pixels.size() * 3);
    for (const glm::vec4& front : image.pixels) {
        const glm::vec4 pixel = over(front, back);
        for (int channel = 0; channel < 3; ++channel) {
            const double value = displayFromLinear(std::clamp(double(pixel[channel]), 0.0, 1.0));
            bytes.push_back(png_byte(std::lround(value * 255)));
        }
    }
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = unsigned(image.size.x);
    png.height = unsigned(image.size.y);
    png.format = PNG_FORMAT_RGB;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    std::string result(size, '\0');
    if (!png_image_write_to_memory(&png, result.data(), &size, 0, bytes.data(), 0, nullptr)) {
        throw OutputError(fmt::format("an image of {}x{} pixels cannot be encoded as PNG: {}", image.size.x,
                                      image.size.y, png.message));
    }
    result.resize(size);
    return result;
}

void writeImage(const std::filesystem::path& path, const Image& image, const ImageHeader& header,
                const Background& background)
{
    writeBytes(path, imageFormat(path) == ImageFormat::kPng ? encodePng(image, background)
                                                            : encodeExr(image, header, background));
}

} // namespace vdblic
