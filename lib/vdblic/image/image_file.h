#pragma once

#include "vdblic/core/parameters.h"
#include "vdblic/image/image.h"

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace vdblic {

enum class ImageFormat { kExr, kPng };

/// The format a file name's extension asks for. @throws ParameterError if it is neither .exr nor .png
[[nodiscard]] ImageFormat imageFormat(const std::filesystem::path& path);

/// An attribute in the header of an EXR file.
using ImageAttribute = std::variant<int, float, std::string, glm::vec2, glm::vec3>;
struct ImageHeader {
    std::vector<std::pair<std::string, ImageAttribute>> attributes;
    glm::mat4 worldToCamera{1}, worldToNdc{1}; ///< OpenEXR's standard attributes
    float screenWindowWidth = 1;               ///< width of the picture at distance 1
};

/// A background as displayed (sRGB) with its own alpha, each 0 to 1.
struct Background {
    glm::dvec3 color{0.04, 0.05, 0.07}; ///< at the bottom, from where it changes evenly to `top`
    double alpha = 0;
    std::optional<glm::dvec3> top{}; ///< unset: one colour for all rows

    /// As displayed. @param down share of the picture's height, 0 at its top to 1
    [[nodiscard]] glm::dvec3 at(double down) const;
    /// The same for the middle of each of a picture's rows, from the top, in linear light.
    [[nodiscard]] std::vector<glm::vec3> rows(int count) const;
    /// @throws ParameterError
    void validate() const;
};
[[nodiscard]] Parameters parametersOf(Background& params);

/// The layers of an .exr file besides colour and alpha.
enum class ImageLayer { kDepth, kNormal, kDriver, kTexture, kSamples };

/// `depth`, `normal`, `magnitude` (the scalar that colours), `texture`, `samples`, or `all`. @throws ParameterError on
/// other names
[[nodiscard]] std::vector<ImageLayer> parseImageLayers(const std::vector<std::string>& names);

/// Content of .exr files.
struct ExrParams {
    std::string precision = "half"; ///< of colour and alpha: `half` or `float`
    /// Channels `Z`, `N.X` `N.Y` `N.Z`, `magnitude`, `texture` and `samples`, 32-bit floats.
    std::vector<ImageLayer> layers{};

    /// @throws ParameterError
    void validate() const;
};
[[nodiscard]] Parameters parametersOf(ExrParams& params);

/// The picture over the background with its alpha, without annotations: a copy of the pixels.
[[nodiscard]] std::vector<glm::vec4> pixelsOver(const Image& image, const Background& background);

/// The bytes of an .exr file: RGBA premultiplied, linear Rec. 709, over the background with its alpha, then layers and
/// the annotations' channels annotation.R, .G, .B and .A.
[[nodiscard]] std::string encodeExr(const Image& image, const ImageHeader& header, const Background& background,
                                    const ExrParams& params = {});
/// The picture as displayed: 8-bit sRGB, toneMapped(), annotations over it and the background's colour behind it; red,
/// green and blue of each pixel, rows from the top. Background and annotations keep their colours: the tone curve
/// leaves values up to the background's brightness unchanged.
[[nodiscard]] std::string displayBytes(const Image& image, const Background& background);
/// The bytes of a .png file that shows displayBytes().
[[nodiscard]] std::string encodePng(const Image& image, const Background& background);

/// Write an image atomically, in the format of its extension.
/// @throws ParameterError; OutputError naming the file and the reason, such as a full disk
void writeImage(const std::filesystem::path& path, const Image& image, const ImageHeader& header,
                const Background& background, const ExrParams& params = {});

/// Whether a file is a whole image of its extension's format, .exr or .png: all of its pixels can be read.
[[nodiscard]] bool isWholeImage(const std::filesystem::path& path);

/// A picture with another exposure: its light times 2^stops.
[[nodiscard]] Image exposed(Image image, double stops);

/// Light that a screen can show, 0 to 1 in each channel, of light that may be brighter: a film's shoulder. Channels of
/// at most `knee` stay as they are. The largest channel of brighter light approaches 1, and its others follow in
/// proportion, so that hues stay; very bright light also fades to white.
///
/// The curve above its toe of the Khronos PBR Neutral Tone Mapper (Khronos Group 2024).
/// @param knee at least kToneKnee; 1: brighter light has a largest channel of 1
[[nodiscard]] glm::vec3 toneMapped(const glm::vec3& light, float knee);
inline constexpr float kToneKnee = 0.8f;

} // namespace vdblic
