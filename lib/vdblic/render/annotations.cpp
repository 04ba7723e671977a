#include "vdblic/render/annotations.h"

#include "vdblic/image/cairo_drawing.h"
#include "vdblic/image/color_map.h"
#include "vdblic/look/look.h"
#include "vdblic/render/annotated_box.h"

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <vector>

namespace vdblic {
namespace {

constexpr const char* kAnnotationFont = "DejaVu Sans";
constexpr glm::dvec3 kLightInk(0.88), kDarkInk(0.12);

/// The name of a scalar with its unit.
std::string scalarTitle(const std::string& name, const std::string& unit)
{
    static const std::map<std::string, std::string> kUnits = {{"vorticity", "1/s"}, {"q", "1/s²"}};
    const auto known = kUnits.find(name);
    const std::string& shown = unit.empty() && known != kUnits.end() ? known->second : unit;
    return shown.empty() ? name : fmt::format("{} [{}]", name, shown);
}

/// An upright scale with numbers at its left and its title above.
/// @param corner top right  @param paint sets the colour at a share of the range
template<typename Paint>
void drawScale(const CairoCanvas& canvas, const glm::dvec2& corner, double height, double textSize,
               const ScalarAxis& axis, const std::string& title, const glm::dvec3& ink, const Paint& paint)
{
    constexpr int kSteps = 128;
    const double width = 0.9 * textSize, left = corner.x - width;
    for (int i = 0; i < kSteps; ++i) {
        paint((i + 0.5) / kSteps);
        // Whole pixels leave no seams.
        const double top = std::round(corner.y + height * (kSteps - 1 - i) / kSteps);
        const double bottom = std::round(corner.y + height * (kSteps - i) / kSteps);
        cairo_rectangle(canvas.context(), left, top, width, bottom - top);
        cairo_fill(canvas.context());
    }
    canvas.setColor(ink);
    cairo_rectangle(canvas.context(), left, corner.y, width, height);
    cairo_stroke(canvas.context());
    for (const auto& [value, text] : ticks(axis, 5)) {
        const double y = corner.y + height * (1 - axis.position(value));
        canvas.drawLine({left - 0.3 * textSize, y}, {left, y});
        canvas.drawText({left - 0.5 * textSize, y + 0.35 * textSize}, 1, text);
    }
    canvas.drawText({corner.x, corner.y - 0.8 * textSize}, 1, title);
}

void drawColorBars(const CairoCanvas& canvas, const AnnotationContent& content, const TransferFunction& transfer,
                   const glm::dvec2& size, double textSize, const glm::dvec3& ink)
{
    const bool one = content.colorBy == content.opacityBy && transfer.range() == transfer.opacityRange() &&
                     transfer.colorAxis().scale == transfer.opacityAxis().scale;
    const double height = size.y * (one ? 0.4 : 0.3), right = size.x - 1.2 * textSize;
    const double top = 3.5 * textSize;
    drawScale(canvas, {right, top}, height, textSize, transfer.colorAxis(),
              scalarTitle(content.colorBy, transfer.params().unit), ink,
              [&](double share) { canvas.setColor(transfer.displayColor(share)); });
    if (one) return;
    // Opacity as ink on the picture: full where a voxel is most opaque.
    double most = 1e-9;
    for (int i = 0; i <= 64; ++i)
        most = std::max(most, transfer.opacityAt(i / 64.0));
    drawScale(canvas, {right, top + height + 3 * textSize}, height, textSize, transfer.opacityAxis(),
              scalarTitle(content.opacityBy, transfer.params().opacityUnit), ink,
              [&](double share) { canvas.setColor(ink, transfer.opacityAt(share) / most); });
    canvas.drawText({right, top + 2 * height + 4.4 * textSize}, 1, "opacity");
}

/// What Cairo drew, in linear light, premultiplied.
std::vector<glm::vec4> pixelsOf(const CairoCanvas& canvas, const glm::ivec2& size)
{
    cairo_surface_flush(canvas.surface());
    const unsigned char* bytes = cairo_image_surface_get_data(canvas.surface());
    const auto stride = std::size_t(cairo_image_surface_get_stride(canvas.surface()));
    std::vector<glm::vec4> pixels(std::size_t(size.x) * std::size_t(size.y), glm::vec4(0));
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        std::uint32_t argb = 0;
        std::memcpy(&argb, bytes + i / std::size_t(size.x) * stride + i % std::size_t(size.x) * 4, sizeof argb);
        const double alpha = argb >> 24;
        if (!(alpha > 0)) continue;
        const glm::dvec3 color = glm::dvec3(argb >> 16 & 255, argb >> 8 & 255, argb & 255) / alpha;
        pixels[i] = glm::vec4(glm::vec3(linearFromDisplay(color)), 1) * float(alpha / 255);
    }
    return pixels;
}

} // namespace

void annotate(Image& image, const AnnotationParams& params, const AnnotationContent& content, const Look& look,
              const Camera& camera, const glm::dvec3& background)
{
    const glm::dvec2 size(image.size);
    const double textSize = std::max(size.y / 42, 7.0), lineWidth = std::max(size.y / 700, 0.7);
    const bool dark = glm::dot(linearFromDisplay(background), glm::dvec3(0.2126, 0.7152, 0.0722)) < 0.2;
    const glm::dvec3 ink = dark ? kLightInk : kDarkInk;
    const auto canvasOf = [&] {
        CairoCanvas canvas(CAIRO_FORMAT_ARGB32, image.size);
        canvas.setColor(ink);
        cairo_set_line_width(canvas.context(), lineWidth);
        cairo_select_font_face(canvas.context(), kAnnotationFont, CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
        cairo_set_font_size(canvas.context(), textSize);
        return canvas;
    };
    const CairoCanvas back = canvasOf(), front = canvasOf();
    if (params.box) {
        drawBox(back, content.box, camera, true);
        drawBox(front, content.box, camera, false);
    }
    if (params.axes) drawAxes(front, content.box, content.stretch, camera, textSize);
    if (params.colorBar) drawColorBars(front, content, look.transfer, size, textSize, ink);
    const double margin = 1.2 * textSize;
    if (params.time) {
        const std::string time = content.time ? fmt::format(", {:.4g} s", *content.time) : "";
        front.drawText({margin, size.y - margin}, 0, fmt::format("frame {}{}", content.frame, time));
    }
    if (!params.title.empty()) {
        cairo_set_font_size(front.context(), 1.5 * textSize);
        front.drawText({margin, margin + textSize}, 0, params.title);
    }
    // The volume hides what lies behind it.
    image.annotations = pixelsOf(front, image.size);
    const std::vector<glm::vec4> behind = pixelsOf(back, image.size);
    for (std::size_t i = 0; i < behind.size(); ++i)
        image.annotations[i] += behind[i] * ((1 - image.annotations[i].a) * (1 - image.pixels[i].a));
}

} // namespace vdblic
