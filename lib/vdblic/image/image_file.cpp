#include "vdblic/image/image_file.h"

#include "vdblic/core/errors.h"
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

void Background::validate() const
{
    for (const double value : {color.r, color.g, color.b, alpha}) {
        if (!(value >= 0 && value <= 1))
            throw ParameterError(fmt::format("background value {} must be between 0 and 1", value));
    }
}

void writeImage(const std::filesystem::path& path, const Image& image, const ImageHeader& header,
                const Background& background, const ExrParams& params)
{
    writeTextFile(path, imageFormat(path) == ImageFormat::kPng ? encodePng(image, background)
                                                               : encodeExr(image, header, background, params));
}

} // namespace vdblic
