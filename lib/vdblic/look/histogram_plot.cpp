#include "vdblic/core/errors.h"
#include "vdblic/image/cairo_drawing.h"
#include "vdblic/look/histogram.h"

#include <fmt/format.h>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

namespace vdblic {
namespace {

constexpr int kPanel = 512, kPitch = 590, kHeight = 460; // width and distance of panels
constexpr const char* kFont = "@cairo:"; // built into Cairo: the same pixels on every machine, no font files
constexpr double kFontSize = 19;
constexpr glm::dvec3 kPaper(0.84), kAxes(0.15), kBars(0.55), kCurve(0.05);

/// A plot's frame in the picture [pixels].
struct Panel {
    glm::dvec2 low, high; ///< top left, bottom right

    [[nodiscard]] double x(double share) const { return low.x + (high.x - low.x) * share; }
    [[nodiscard]] double y(double share) const { return high.y + (low.y - high.y) * share; }
};

/// @param color of the bar of a bin
template<typename Color>
void drawBars(const CairoCanvas& canvas, const Panel& panel, const Histogram& histogram, const Color& color)
{
    // Square roots, so that a few crowded bins do not flatten all others.
    cairo_t* cairo = canvas.context();
    const double most = std::sqrt(double(*std::max_element(histogram.counts.begin(), histogram.counts.end())));
    for (std::size_t i = 0; most > 0 && i < Histogram::kBins; ++i) {
        const double share = std::sqrt(double(histogram.counts[i])) / most,
                     left = panel.x(double(i) / Histogram::kBins);
        canvas.setColor(color(i));
        cairo_rectangle(cairo, left, panel.y(share), panel.x(double(i + 1) / Histogram::kBins) - left,
                        panel.high.y - panel.y(share));
        cairo_fill(cairo);
    }
}

void drawFrame(const CairoCanvas& canvas, const Panel& panel, const Histogram& histogram, const std::string& title)
{
    constexpr int kTicks = 4;
    canvas.setColor(kAxes);
    cairo_set_line_width(canvas.context(), 1);
    for (int i = 0; i <= kTicks; ++i) {
        const double share = double(i) / kTicks;
        canvas.drawLine({panel.x(share), panel.high.y}, {panel.x(share), panel.high.y + 6});
        canvas.drawText({panel.x(share), panel.high.y + 26}, 0.5, fmt::format("{:.3g}", histogram.axis().value(share)));
    }
    canvas.drawLine({panel.low.x, panel.high.y}, panel.high);
    canvas.drawText({panel.x(0.5), panel.low.y - 16}, 0.5, title);
    const double outside =
        double(histogram.below + histogram.above) / double(std::max(histogram.total(), std::uint64_t(1)));
    canvas.drawText({panel.x(0.5), panel.high.y + 52}, 0.5,
                    fmt::format("square root of voxels ({:.2g}% outside)", outside * 100));
}

/// The opacity over the driver, and at the right edge its scale, which ends at the curve's largest value.
void drawOpacity(const CairoCanvas& canvas, const Panel& panel, const Histogram& histogram,
                 const TransferFunction& transfer)
{
    cairo_t* cairo = canvas.context();
    const auto opacity = [&](double driver) {
        const auto entry = transfer.entries(broadcast8(float(driver)))[0];
        return -std::expm1(-double(transfer.table()[entry].extinction));
    };
    double most = 0;
    for (const OpacityPoint& point : transfer.opacity())
        most = std::max(most, point.opacity);
    if (!(most > 0)) most = 1;
    constexpr int kTicks = 4;
    canvas.setColor(kCurve);
    cairo_set_line_width(cairo, 1);
    for (int i = 0; i <= kTicks; ++i) {
        const double share = double(i) / kTicks;
        canvas.drawLine({panel.high.x, panel.y(share)}, {panel.high.x + 4, panel.y(share)});
        canvas.drawText({panel.high.x + 8, panel.y(share) + 6}, 0, fmt::format("{:.2g}", most * share));
    }
    canvas.drawText({panel.high.x + 8, panel.low.y - 16}, 0.5, "opacity");

    const int pixels = int(panel.high.x - panel.low.x);
    for (int i = 0; i <= pixels; ++i) {
        const double share = double(i) / pixels;
        const double driver = histogram.axis().value(share);
        cairo_line_to(cairo, panel.x(share), panel.y(opacity(driver) / most));
    }
    // A light edge separates the curve from bars of its own colour.
    cairo_set_line_width(cairo, 5);
    canvas.setColor(kPaper);
    cairo_stroke_preserve(cairo);
    cairo_set_line_width(cairo, 2);
    canvas.setColor(kCurve);
    cairo_stroke(cairo);
}

std::string toPng(cairo_surface_t* surface)
{
    std::string bytes;
    const auto append = [](void* target, const unsigned char* data, unsigned count) {
        static_cast<std::string*>(target)->append(reinterpret_cast<const char*>(data), count);
        return CAIRO_STATUS_SUCCESS;
    };
    const cairo_status_t status = cairo_surface_write_to_png_stream(surface, append, &bytes);
    if (status != CAIRO_STATUS_SUCCESS)
        throw OutputError(fmt::format("the histograms cannot be drawn: {}", cairo_status_to_string(status)));
    return bytes;
}

} // namespace

std::string histogramPng(const TextureHistograms& histograms, const Look& look, const ScalarNames& names)
{
    const bool one = names.color == names.opacity;
    const CairoCanvas canvas(CAIRO_FORMAT_RGB24, {60 + kPitch * (one ? 2 : 3), kHeight});
    cairo_t* cairo = canvas.context();
    canvas.setColor(kPaper);
    cairo_paint(cairo);
    cairo_select_font_face(cairo, kFont, CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(cairo, kFontSize);

    const auto panel = [](int i) {
        const double left = 40 + kPitch * i;
        return Panel{{left, 60}, {left + kPanel, 380}};
    };
    const auto plain = [](std::size_t) { return kBars; };
    drawBars(canvas, panel(0), histograms.texture, plain);
    drawFrame(canvas, panel(0), histograms.texture, "texture");

    const Histogram& colors = histograms.color;
    drawBars(canvas, panel(1), colors, [&](std::size_t bin) {
        const double value = colors.axis().value((double(bin) + 0.5) / Histogram::kBins);
        return look.transfer.displayColor(look.transfer.colorAxis().position(value));
    });
    const Panel opaque = panel(one ? 1 : 2);
    if (!one) {
        drawBars(canvas, opaque, histograms.opacity, plain);
        drawFrame(canvas, opaque, histograms.opacity, names.opacity);
    }
    drawOpacity(canvas, opaque, histograms.opacity, look.transfer);
    drawFrame(canvas, panel(1), colors, names.color);
    return toPng(canvas.surface());
}

} // namespace vdblic
