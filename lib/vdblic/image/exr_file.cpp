#include "vdblic/core/errors.h"
#include "vdblic/core/version.h"
#include "vdblic/image/image_file.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticities.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfVecAttribute.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace vdblic {
namespace {

constexpr std::pair<std::string_view, ImageLayer> kLayers[] = {
    {"depth", ImageLayer::kDepth},     {"normal", ImageLayer::kNormal},   {"magnitude", ImageLayer::kDriver},
    {"texture", ImageLayer::kTexture}, {"samples", ImageLayer::kSamples},
};

/// A file in memory. Writing to disk, with its checks, is left to writeTextFile().
class MemoryStream : public Imf::OStream {
  public:
    MemoryStream() : Imf::OStream("memory") {}

    void write(const char bytes[], int count) override
    {
        if (mOffset + std::size_t(count) > mBytes.size()) mBytes.resize(mOffset + std::size_t(count));
        std::memcpy(mBytes.data() + mOffset, bytes, std::size_t(count));
        mOffset += std::size_t(count);
    }
    std::uint64_t tellp() override { return mOffset; }
    void seekp(std::uint64_t offset) override { mOffset = offset; }

    [[nodiscard]] std::string take() { return std::move(mBytes); }

  private:
    std::string mBytes;
    std::size_t mOffset = 0;
};

/// GLM's columns are Imath's rows: Imath multiplies row vectors from the left.
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

/// A file's channels and the memory layout of each.
struct Channels {
    Imf::Header& header;
    Imf::FrameBuffer frame{};

    /// @param first value of the first pixel; the others follow at a stride of `pixelBytes`
    void add(const char* name, Imf::PixelType type, const void* first, std::size_t pixelBytes)
    {
        const auto width = std::size_t(header.dataWindow().max.x) + 1;
        header.channels().insert(name, Imf::Channel(type));
        // OpenEXR has the same slices for reading and for writing, so they are never const.
        auto* bytes = const_cast<char*>(static_cast<const char*>(first));
        frame.insert(name, Imf::Slice(type, bytes, pixelBytes, pixelBytes * width));
    }
    void add(ImageLayer layer, const PixelLayers& first)
    {
        const auto addFloat = [&](const char* name, const float& value) {
            add(name, Imf::FLOAT, &value, sizeof(PixelLayers));
        };
        switch (layer) {
        case ImageLayer::kDepth:
            return addFloat("Z", first.depth);
        case ImageLayer::kDriver:
            return addFloat("magnitude", first.driver);
        case ImageLayer::kTexture:
            return addFloat("texture", first.texture);
        case ImageLayer::kSamples:
            return addFloat("samples", first.samples);
        case ImageLayer::kNormal:
            addFloat("N.X", first.normal.x);
            addFloat("N.Y", first.normal.y);
            addFloat("N.Z", first.normal.z);
        }
    }
};

/// The file with pixels of Value, which is `half` or `float`.
template<typename Value>
std::string encode(const Image& image, Imf::Header& exr, const Background& background, const ExrParams& params)
{
    using Pixel = std::array<Value, 4>;
    std::vector<Pixel> pixels(image.pixels.size());
    const std::vector<glm::vec4> over = pixelsOver(image, background);
    for (std::size_t i = 0; i < pixels.size(); ++i)
        pixels[i] = {over[i].r, over[i].g, over[i].b, over[i].a};
    Channels channels{exr};
    constexpr const char* kColors[] = {"R", "G", "B", "A"};
    for (std::size_t i = 0; i < 4; ++i) {
        channels.add(kColors[i], sizeof(Value) == 2 ? Imf::HALF : Imf::FLOAT, &pixels[0][i], sizeof(Pixel));
    }
    for (const ImageLayer layer : params.layers)
        channels.add(layer, image.layers.at(0));
    std::vector<Pixel> annotations(image.annotations.size());
    for (std::size_t i = 0; i < annotations.size(); ++i) {
        const glm::vec4& pixel = image.annotations[i];
        annotations[i] = {pixel.r, pixel.g, pixel.b, pixel.a};
    }
    for (std::size_t i = 0; i < 4 && !annotations.empty(); ++i) {
        channels.add(fmt::format("annotation.{}", kColors[i]).c_str(), sizeof(Value) == 2 ? Imf::HALF : Imf::FLOAT,
                     &annotations[0][i], sizeof(Pixel));
    }

    MemoryStream stream;
    {
        Imf::OutputFile file(stream, exr);
        file.setFrameBuffer(channels.frame);
        file.writePixels(image.size.y);
    }
    return stream.take();
}

} // namespace

std::vector<ImageLayer> parseImageLayers(const std::vector<std::string>& names)
{
    std::vector<ImageLayer> layers;
    for (const std::string& name : names) {
        bool known = false;
        for (const auto& [layerName, layer] : kLayers) {
            if (name != layerName && name != "all") continue;
            known = true;
            layers.push_back(layer);
        }
        if (!known) {
            throw ParameterError(
                fmt::format("'{}' is no layer; known are depth, normal, magnitude, texture, samples and all", name));
        }
    }
    return layers;
}

Parameters parametersOf(ExrParams& params)
{
    const auto layerNames = [&params] {
        Words names;
        for (const auto& [name, layer] : kLayers) {
            if (std::find(params.layers.begin(), params.layers.end(), layer) != params.layers.end())
                names.emplace_back(name);
        }
        return names;
    };
    Parameter layers = parameter(
        "aov", "Further channels of .exr: depth, normal, magnitude, texture, samples, or all.", WordType::kText, 1,
        [&params](const Words& words) { params.layers = parseImageLayers(words); }, layerNames, {.words = "NAME,NAME"});
    layers.most = WordsOf<std::vector<std::string>>::kMost;
    Parameter precision =
        parameter("precision", "Of colour and alpha in .exr.", params.precision, {.words = "NUMBERS"});
    precision.choices = {"half", "float"};
    precision.get = [&params] { return Words{params.precision}; };
    return {layers, precision};
}

void ExrParams::validate() const
{
    ExrParams copy = *this;
    checkLimits(parametersOf(copy));
}

std::string encodeExr(const Image& image, const ImageHeader& header, const Background& background,
                      const ExrParams& params)
{
    params.validate();
    Imf::Header exr(image.size.x, image.size.y, 1, {0, 0}, header.screenWindowWidth);
    Imf::addChromaticities(exr, Imf::Chromaticities{}); // Rec. 709 is OpenEXR's default
    Imf::addWorldToCamera(exr, imathMatrix(header.worldToCamera));
    Imf::addWorldToNDC(exr, imathMatrix(header.worldToNdc));
    exr.insert("creator", Imf::StringAttribute(kCreator));
    for (const auto& [name, value] : header.attributes)
        std::visit(InsertAttribute{exr, name}, value);
    return params.precision == "half" ? encode<Imath::half>(image, exr, background, params)
                                      : encode<float>(image, exr, background, params);
}

} // namespace vdblic
