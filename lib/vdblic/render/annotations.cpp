#include "vdblic/render/annotations.h"

#include "vdblic/camera/framing.h"
#include "vdblic/field/globe.h"
#include "vdblic/image/cairo_drawing.h"
#include "vdblic/image/color_map.h"
#include "vdblic/look/look.h"
#include "vdblic/look/transfer_function.h"
#include "vdblic/render/annotated_box.h"
#include "vdblic/render/annotation_font.h"
#include "vdblic/render/annotation_scale.h"

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

/// Draw the names of kinds at the left of their colours, one below the other in the order of their numbers, and the
/// unclassified one last.
/// @param corner top right [pixels]  @param textSize of the canvas's font [pixels]
/// @return the lower end of the drawing
double drawLegend(const CairoCanvas& canvas, const glm::dvec2& corner, double textSize, const std::string& title,
                  const TransferFunction& transfer, const glm::dvec3& ink)
{
    const std::vector<std::string>& kinds = transfer.params().kinds;
    const double side = 0.9 * textSize, line = 1.5 * textSize;
    canvas.drawText({corner.x, corner.y - 0.8 * textSize}, 1, title);
    double top = corner.y;
    for (std::size_t i = 1; i <= kinds.size(); ++i) {
        const std::size_t kind = i % kinds.size();
        canvas.setColor(transfer.displayColor(transfer.colorAxis().position(double(kind))));
        cairo_rectangle(canvas.context(), corner.x - side, top, side, side);
        cairo_fill(canvas.context());
        canvas.setColor(ink);
        cairo_rectangle(canvas.context(), corner.x - side, top, side, side);
        cairo_stroke(canvas.context());
        canvas.drawText({corner.x - side - 0.5 * textSize, top + 0.8 * textSize}, 1, kinds[kind]);
        top += line;
    }
    return top - line + side;
}

// In sizes of the text; a picture's height is kLines of them.
constexpr double kLines = 42, kMargin = 1.2, kBarTop = 3.5;
constexpr double kBarRoom = 6.5; // a bar with its numbers and margin

constexpr glm::dvec3 kLightInk(0.88), kDarkInk(0.12);

/// A scalar's name and unit.
struct ScaleName {
    std::string name, unit;
};

/// An upright scale with numbers at its left and its title above. Very large and very small numbers have a power of
/// ten in the title.
/// @param corner top right  @param paint sets the colour at a share of the range
template<typename Paint>
void drawScale(const CairoCanvas& canvas, Labels& labels, const glm::dvec2& corner, double height, double textSize,
               const ScalarAxis& axis, const ScaleName& name, const glm::dvec3& ink, const Paint& paint)
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
    const int wanted = int(std::clamp(height / (1.5 * textSize), 1.0, 5.0));
    const auto [low, high] = axis.range;
    const AxisUnit unit = axis.scale == ValueScale::kLinear
                              ? axisUnit(std::max(std::abs(low), std::abs(high)), name.unit)
                              : AxisUnit{1, name.unit};
    for (const auto& [value, text] : ticks({{low / unit.factor, high / unit.factor}, axis.scale}, wanted)) {
        const double y = corner.y + height * (1 - axis.position(value * unit.factor));
        canvas.drawLine({left - 0.3 * textSize, y}, {left, y});
        canvas.drawText({left - 0.5 * textSize, y + 0.35 * textSize}, 1, text);
    }
    const std::string title = scalarTitle(name.name, unit.text);
    canvas.drawText({corner.x, corner.y - 0.8 * textSize}, 1, title);
    labels.keepFree({{corner.x - labels.extent(title).x, corner.y - 2 * textSize}, corner});
}

const std::string& either(const std::string& given, const std::string& known)
{
    return given.empty() ? known : given;
}

/// The font of a text that is to be drawn.
void selectFont(const CairoCanvas& canvas, const std::string& text, double textSize)
{
    const std::string family = annotationFont(text).family;
    cairo_select_font_face(canvas.context(), family.c_str(), CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(canvas.context(), textSize);
}

/// @return the lower end of the drawing
double drawColorBars(const CairoCanvas& canvas, Labels& labels, const AnnotationContent& content,
                     const TransferFunction& transfer, const glm::dvec2& size, double textSize, const glm::dvec3& ink)
{
    const bool one = content.colorBy == content.opacityBy && transfer.range() == transfer.opacityRange() &&
                     transfer.colorAxis().scale == transfer.opacityAxis().scale;
    const bool hasLines = content.lines.look && content.lines.opacityBy != content.colorBy;
    const double height = size.y * (one && !hasLines ? 0.4 : one || !hasLines ? 0.3 : 0.2);
    const double right = size.x - kMargin * textSize;
    const double top = kBarTop * textSize;
    const ScaleName name{content.colorBy,
                         scalarUnit(content.colorBy, either(transfer.params().unit, content.colorUnit))};
    double end = top + height;
    if (transfer.params().kinds.empty()) {
        drawScale(canvas, labels, {right, top}, height, textSize, transfer.colorAxis(), name, ink,
                  [&](double share) { canvas.setColor(transfer.displayColor(share)); });
    } else {
        end = drawLegend(canvas, {right, top}, textSize, scalarTitle(name.name, name.unit), transfer, ink);
    }
    const auto drawOpacity = [&](const TransferFunction& of, const std::string& by, const std::string& unit,
                                 const char* what) {
        // As ink on the picture: full where a voxel is most opaque.
        double most = 1e-9;
        for (int i = 0; i <= 64; ++i)
            most = std::max(most, of.opacityAt(i / 64.0));
        drawScale(canvas, labels, {right, end + 3 * textSize}, height, textSize, of.opacityAxis(),
                  {by, scalarUnit(by, either(of.params().opacityUnit, unit))}, ink,
                  [&](double share) { canvas.setColor(ink, of.opacityAt(share) / most); });
        end += height + 4.4 * textSize;
        canvas.drawText({right, end}, 1, what);
    };
    if (!one) drawOpacity(transfer, content.opacityBy, content.opacityUnit, "opacity");
    if (hasLines)
        drawOpacity(content.lines.look->transfer, content.lines.opacityBy, content.lines.opacityUnit, "line opacity");
    return end;
}

/// Cairo's drawing in linear light, premultiplied.
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

/// A dot and a name, if the place is on the side of the globe that the camera sees.
void drawPlace(const CairoCanvas& canvas, const NamedPlace& place, const glm::dvec3& stretch, const Camera& camera,
               double textSize, const glm::dvec3& ink, const glm::dvec3& background)
{
    const double east = glm::radians(place.longitude), north = glm::radians(place.latitude);
    const glm::dvec3 outward(std::cos(north) * std::cos(east), std::cos(north) * std::sin(east), std::sin(north));
    const glm::dvec3 at = outward * kEarthRadius * stretch;
    const glm::dvec4 ndc = camera.worldToNdc() * glm::dvec4(at, 1);
    if (!(ndc.w > 0) || !(glm::dot(camera.eye() - at, outward) > 0)) return;
    const glm::dvec2 pixel = glm::dvec2(ndc) / ndc.w * glm::dvec2(camera.size());
    const glm::dvec2 beside = pixel + glm::dvec2(0.6, 0.35) * textSize;
    selectFont(canvas, place.name, textSize);
    canvas.setColor(background);
    for (const glm::dvec2 shift : {glm::dvec2(1, 1), glm::dvec2(-1, 1), glm::dvec2(1, -1), glm::dvec2(-1, -1)})
        canvas.drawText(beside + shift * (textSize / 14), 0, place.name);
    canvas.setColor(ink);
    canvas.drawText(beside, 0, place.name);
    cairo_arc(canvas.context(), pixel.x, pixel.y, textSize / 5, 0, 2 * std::numbers::pi);
    cairo_fill(canvas.context());
    selectFont(canvas, "", textSize);
}

} // namespace

std::vector<glm::dvec3> withRoom(std::vector<glm::dvec3> subject, const AnnotationParams& params, const Camera& view)
{
    if (subject.empty()) return subject;
    const glm::dmat3 axes = viewAxes(glm::normalize(view.target() - view.eye()), view.up());
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
    for (const glm::dvec3& point : subject) {
        low = glm::min(low, point * axes);
        high = glm::max(high, point * axes);
    }
    if (params.axes) {
        // Numbers beside the axes.
        constexpr double kRoom = 1.22;
        const glm::dvec3 middle = axes * ((low + high) / 2.0);
        for (glm::dvec3& point : subject)
            point = glm::mix(middle, point, kRoom);
    }
    if (params.colorBar) {
        // Reserve the bar's share of the picture at the right; the subject fills the rest.
        const double share = kBarRoom / kLines * view.size().y / view.size().x;
        const glm::dvec3 aside = axes[0] * ((high.x - low.x) * share / (1 - std::min(share, 0.5)));
        for (std::size_t i = 0, count = subject.size(); i < count; ++i)
            subject.push_back(subject[i] + aside);
    }
    return subject;
}

void annotate(Image& image, const AnnotationParams& params, const AnnotationContent& content, const Look& look,
              const Camera& camera, const glm::dvec3& background)
{
    const glm::dvec2 size(image.size);
    const double textSize = std::max(size.y / kLines, 7.0), lineWidth = std::max(size.y / 700, 0.7);
    const bool dark = glm::dot(linearFromDisplay(background), glm::dvec3(0.2126, 0.7152, 0.0722)) < 0.2;
    const glm::dvec3 ink = dark ? kLightInk : kDarkInk;
    const auto canvasOf = [&] {
        CairoCanvas canvas(CAIRO_FORMAT_ARGB32, image.size);
        canvas.setColor(ink);
        cairo_set_line_width(canvas.context(), lineWidth);
        selectFont(canvas, "", textSize);
        return canvas;
    };
    const CairoCanvas back = canvasOf(), front = canvasOf();
    if (params.box) {
        drawBox(back, content.box, camera, true);
        drawBox(front, content.box, camera, false);
    }
    Labels labels(front, size, textSize);
    const double margin = kMargin * textSize;
    double bottom = size.y - margin; // of the next annotation at the left
    if (params.colorBar) {
        const double end = drawColorBars(front, labels, content, look.transfer, size, textSize, ink);
        labels.keepFree({{size.x - kBarRoom * textSize, 0}, {size.x, end + textSize}});
    }
    if (params.time) {
        const std::string clock = clockText(content.clock);
        const std::string text =
            fmt::format("frame {}{}{}", paddedText(content.frame, content.lastFrame), clock.empty() ? "" : ", ", clock);
        front.drawText({margin, size.y - margin}, 0, text);
        labels.keepFree({{0, size.y - margin - textSize}, {margin + labels.extent(text).x, size.y}});
        bottom -= 1.6 * textSize;
    }
    if (params.scaleBar) {
        const ScaleBar bar = scaleBar(camera, content.stretch);
        const double top = drawScaleBar(front, {margin, bottom}, textSize, bar, content.lengthUnit);
        labels.keepFree({{0, top}, {margin + bar.width + textSize, bottom}});
        bottom = top - 0.4 * textSize;
    }
    if (params.triad) {
        const AxisNames names = content.isGeographic ? AxisNames{"E", "N", "up"} : AxisNames{"x", "y", "z"};
        const double top = drawTriad(front, {margin, bottom}, textSize, camera, names);
        labels.keepFree({{0, top}, {margin + (bottom - top), bottom}});
    }
    for (const NamedPlace& place : params.places)
        drawPlace(front, place, content.stretch, camera, textSize, ink, background);
    if (!params.title.empty()) {
        selectFont(front, params.title, 1.5 * textSize);
        front.drawText({margin, margin + textSize}, 0, params.title);
        labels.keepFree({{0, 0}, {margin + labels.extent(params.title).x, margin + 1.5 * textSize}});
        selectFont(front, "", textSize);
    }
    if (params.axes) drawAxes(front, labels, content.box, content.stretch, content.lengthUnit, camera, textSize);
    // The volume hides the far edges.
    image.annotations = pixelsOf(front, image.size);
    const std::vector<glm::vec4> behind = pixelsOf(back, image.size);
    for (std::size_t i = 0; i < behind.size(); ++i)
        image.annotations[i] += behind[i] * ((1 - image.annotations[i].a) * (1 - image.pixels[i].a));
}

} // namespace vdblic
