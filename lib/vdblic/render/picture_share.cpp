#include "vdblic/render/picture_share.h"

#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

/// Call row(first, count) for the pixels of each row of an area.
template<typename Row>
void forRows(const Image& image, const PictureArea& area, const Row& row)
{
    for (int y = area.low.y; y < area.high.y && area.low.x < area.high.x; ++y) {
        row(std::size_t(y) * std::size_t(image.size.x) + std::size_t(area.low.x),
            std::size_t(area.high.x - area.low.x));
    }
}

/// Append an area of a picture's pixels or layers to a message.
template<typename T>
void give(const Image& image, const std::vector<T>& values, const PictureArea& area, Exchange::Bytes& message)
{
    if (values.empty()) return;
    forRows(image, area, [&](std::size_t first, std::size_t count) {
        message.append(reinterpret_cast<const char*>(values.data() + first), count * sizeof(T));
    });
}

/// Move the values that give() appended out of the message.
template<typename T>
void take(const Image& image, std::vector<T>& values, const PictureArea& area, std::string_view& message)
{
    if (values.empty()) return;
    forRows(image, area, [&](std::size_t first, std::size_t count) {
        if (message.size() < count * sizeof(T)) throw std::logic_error("a part of a picture is too small");
        std::memcpy(static_cast<void*>(values.data() + first), message.data(), count * sizeof(T));
        message.remove_prefix(count * sizeof(T));
    });
}

} // namespace

void PictureShare::assemble(Image& image) const
{
    Exchange::Bytes mine;
    if (!exchange.isFirst()) {
        give(image, image.pixels, area(), mine);
        give(image, image.layers, area(), mine);
    }
    const std::vector<Exchange::Bytes> parts = exchange.gather(std::move(mine));
    for (std::size_t rank = 1; rank < parts.size(); ++rank) {
        std::string_view part = parts[rank];
        take(image, image.pixels, cuts.area(int(rank)), part);
        take(image, image.layers, cuts.area(int(rank)), part);
    }
}

} // namespace vdblic
