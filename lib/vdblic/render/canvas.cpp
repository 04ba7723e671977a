#include "vdblic/render/canvas.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <cmath>

namespace vdblic {
namespace {

constexpr int kGlyphWidth = 5, kGlyphHeight = 7;
constexpr int kScale = 2; // pixels to a dot of a glyph

/// A letter of 5 columns of dots; the lowest bit is the top one.
struct Glyph {
    char letter;
    std::uint8_t columns[kGlyphWidth];
};

constexpr Glyph kGlyphs[] = {
    {'0', {0x3e, 0x51, 0x49, 0x45, 0x3e}}, {'1', {0x00, 0x42, 0x7f, 0x40, 0x00}}, {'2', {0x42, 0x61, 0x51, 0x49, 0x46}},
    {'3', {0x21, 0x41, 0x45, 0x4b, 0x31}}, {'4', {0x18, 0x14, 0x12, 0x7f, 0x10}}, {'5', {0x27, 0x45, 0x45, 0x45, 0x39}},
    {'6', {0x3c, 0x4a, 0x49, 0x49, 0x30}}, {'7', {0x01, 0x71, 0x09, 0x05, 0x03}}, {'8', {0x36, 0x49, 0x49, 0x49, 0x36}},
    {'9', {0x06, 0x49, 0x49, 0x29, 0x1e}}, {'a', {0x20, 0x54, 0x54, 0x54, 0x78}}, {'b', {0x7f, 0x48, 0x44, 0x44, 0x38}},
    {'c', {0x38, 0x44, 0x44, 0x44, 0x20}}, {'d', {0x38, 0x44, 0x44, 0x48, 0x7f}}, {'e', {0x38, 0x54, 0x54, 0x54, 0x18}},
    {'f', {0x08, 0x7e, 0x09, 0x01, 0x02}}, {'g', {0x0c, 0x52, 0x52, 0x52, 0x3e}}, {'h', {0x7f, 0x08, 0x04, 0x04, 0x78}},
    {'i', {0x00, 0x44, 0x7d, 0x40, 0x00}}, {'j', {0x20, 0x40, 0x44, 0x3d, 0x00}}, {'k', {0x7f, 0x10, 0x28, 0x44, 0x00}},
    {'l', {0x00, 0x41, 0x7f, 0x40, 0x00}}, {'m', {0x7c, 0x04, 0x18, 0x04, 0x78}}, {'n', {0x7c, 0x08, 0x04, 0x04, 0x78}},
    {'o', {0x38, 0x44, 0x44, 0x44, 0x38}}, {'p', {0x7c, 0x14, 0x14, 0x14, 0x08}}, {'q', {0x08, 0x14, 0x14, 0x18, 0x7c}},
    {'r', {0x7c, 0x08, 0x04, 0x04, 0x08}}, {'s', {0x48, 0x54, 0x54, 0x54, 0x20}}, {'t', {0x04, 0x3f, 0x44, 0x40, 0x20}},
    {'u', {0x3c, 0x40, 0x40, 0x20, 0x7c}}, {'v', {0x1c, 0x20, 0x40, 0x20, 0x1c}}, {'w', {0x3c, 0x40, 0x30, 0x40, 0x3c}},
    {'x', {0x44, 0x28, 0x10, 0x28, 0x44}}, {'y', {0x0c, 0x50, 0x50, 0x50, 0x3c}}, {'z', {0x44, 0x64, 0x54, 0x4c, 0x44}},
    {'.', {0x00, 0x60, 0x60, 0x00, 0x00}}, {'-', {0x08, 0x08, 0x08, 0x08, 0x08}}, {'+', {0x08, 0x08, 0x3e, 0x08, 0x08}},
    {'/', {0x20, 0x10, 0x08, 0x04, 0x02}}, {'%', {0x23, 0x13, 0x08, 0x64, 0x62}}, {'(', {0x00, 0x1c, 0x22, 0x41, 0x00}},
    {')', {0x00, 0x41, 0x22, 0x1c, 0x00}}, {'[', {0x00, 0x7f, 0x41, 0x41, 0x00}}, {']', {0x00, 0x41, 0x41, 0x7f, 0x00}},
};

/// How much of pixel i lies between two places.
double overlap(int i, double low, double high)
{
    return std::clamp(std::min(high, i + 1.0) - std::max(low, double(i)), 0.0, 1.0);
}

} // namespace

Canvas::Canvas(const glm::ivec2& size, const glm::dvec3& color)
    : mSize(size), mBytes(std::size_t(size.x) * std::size_t(size.y) * 3)
{
    rectangle({0, 0}, size, color);
}

void Canvas::mix(int x, int y, const glm::dvec3& color, double share)
{
    if (x < 0 || y < 0 || x >= mSize.x || y >= mSize.y) return;
    std::uint8_t* pixel = mBytes.data() + (std::size_t(y) * std::size_t(mSize.x) + std::size_t(x)) * 3;
    for (int i = 0; i < 3; ++i)
        pixel[i] = std::uint8_t(std::lround(pixel[i] + (color[i] * 255 - pixel[i]) * share));
}

void Canvas::rectangle(const glm::dvec2& low, const glm::dvec2& high, const glm::dvec3& color)
{
    for (int y = int(std::floor(low.y)); y < int(std::ceil(high.y)); ++y) {
        for (int x = int(std::floor(low.x)); x < int(std::ceil(high.x)); ++x)
            mix(x, y, color, overlap(x, low.x, high.x) * overlap(y, low.y, high.y));
    }
}

void Canvas::line(const glm::dvec2& from, const glm::dvec2& to, double width, const glm::dvec3& color)
{
    const glm::dvec2 along = to - from;
    const double squared = std::max(glm::dot(along, along), 1e-12);
    const glm::ivec2 low(glm::floor(glm::min(from, to) - width)), high(glm::ceil(glm::max(from, to) + width));
    for (int y = low.y; y < high.y; ++y) {
        for (int x = low.x; x < high.x; ++x) {
            const glm::dvec2 offset = glm::dvec2(x + 0.5, y + 0.5) - from;
            const double t = std::clamp(glm::dot(offset, along) / squared, 0.0, 1.0);
            mix(x, y, color, std::clamp(width / 2 + 0.5 - glm::length(offset - along * t), 0.0, 1.0));
        }
    }
}

void Canvas::text(const glm::dvec2& place, double anchor, std::string_view what, const glm::dvec3& color)
{
    constexpr int kAdvance = (kGlyphWidth + 1) * kScale;
    glm::dvec2 corner = glm::floor(place - glm::dvec2(anchor * kAdvance * double(what.size()), kGlyphHeight * kScale));
    for (const char letter : what) {
        const auto* glyph = std::find_if(std::begin(kGlyphs), std::end(kGlyphs),
                                         [&](const Glyph& candidate) { return candidate.letter == letter; });
        for (int dot = 0; glyph != std::end(kGlyphs) && dot < kGlyphWidth * kGlyphHeight; ++dot) {
            const int x = dot / kGlyphHeight, y = dot % kGlyphHeight;
            if (!(glyph->columns[x] >> y & 1)) continue;
            const glm::dvec2 low = corner + glm::dvec2(x, y) * double(kScale);
            rectangle(low, low + double(kScale), color);
        }
        corner.x += kAdvance;
    }
}

} // namespace vdblic
