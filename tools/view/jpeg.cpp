#include "view/jpeg.h"

#include <fmt/format.h>
#include <turbojpeg.h>

#include <memory>
#include <stdexcept>

namespace vdblic::view {

std::string encodeJpeg(std::string_view pixels, const glm::ivec2& size, int quality)
{
    const std::unique_ptr<void, int (*)(tjhandle)> jpeg(tjInitCompress(), tjDestroy);
    unsigned char* bytes = nullptr;
    unsigned long length = 0;
    const int failed = tjCompress2(jpeg.get(), reinterpret_cast<const unsigned char*>(pixels.data()), size.x, 0, size.y,
                                   TJPF_RGB, &bytes, &length, quality < 90 ? TJSAMP_420 : TJSAMP_444, quality, 0);
    const std::unique_ptr<unsigned char, void (*)(unsigned char*)> freed(bytes, tjFree);
    if (failed != 0) throw std::runtime_error(fmt::format("JPEG: {}", tjGetErrorStr2(jpeg.get())));
    return {reinterpret_cast<const char*>(bytes), length};
}

} // namespace vdblic::view
