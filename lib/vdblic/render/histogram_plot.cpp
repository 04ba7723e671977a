#include "vdblic/render/canvas.h"
#include "vdblic/render/color_map.h"
#include "vdblic/render/histogram.h"
#include "vdblic/render/image_file.h"

#include <cmath>

namespace vdblic {
namespace {

constexpr glm::dvec3 kPaper(1), kInk(0.15), kBars(0.55), kCurve(0.05);

/// A plot's frame on the canvas.
struct Panel {
    glm::dvec2 low, high; ///< top left, bottom right

    [[nodiscard]] double x(double share) const { return low.x + (high.x - low.x) * share; }
    [[nodiscard]] double y(double share) const { return high.y + (low.y - high.y) * share; }
};

/// @param color of the bar of a bin
template<typename Color>
void drawBars(Canvas& canvas, const Panel& panel, const Histogram& histogram, const Color& color)
{
    // Square roots, so that a few crowded bins do not flatten all others.
    const double most = std::sqrt(double(*std::max_element(histogram.counts.begin(), histogram.counts.end())));
    for (std::size_t i = 0; most > 0 && i < Histogram::kBins; ++i) {
        const double share = std::sqrt(double(histogram.counts[i])) / most;
        canvas.rectangle({panel.x(double(i) / Histogram::kBins), panel.y(share)},
                         {panel.x(double(i + 1) / Histogram::kBins), panel.high.y}, color(i));
    }
}

void drawFrame(Canvas& canvas, const Panel& panel, const Histogram& histogram, const char* title)
{
    constexpr int kTicks = 4;
    for (int i = 0; i <= kTicks; ++i) {
        const double share = double(i) / kTicks, value = histogram.low + (histogram.high - histogram.low) * share;
        canvas.line({panel.x(share), panel.high.y}, {panel.x(share), panel.high.y + 6}, 1, kInk);
        canvas.text({panel.x(share), panel.high.y + 26}, 0.5, fmt::format("{:.3g}", value), kInk);
    }
    canvas.line({panel.low.x, panel.high.y}, panel.high, 1, kInk);
    canvas.text({panel.x(0.5), panel.low.y - 16}, 0.5, title, kInk);
    const double outside = double(histogram.below + histogram.above) / double(std::max(histogram.total(), 1ul));
    canvas.text({panel.x(0.5), panel.high.y + 52}, 0.5,
                fmt::format("square root of voxels ({:.2g}% outside)", outside * 100), kInk);
}

/// The opacity over the magnitudes, and its scale at the right edge, which ends at the curve's largest value.
void drawOpacity(Canvas& canvas, const Panel& panel, const Histogram& histogram, const TransferFunction& transfer)
{
    const auto opacity = [&](double magnitude) {
        const auto entry = transfer.entries(broadcast8(float(magnitude)))[0];
        return -std::expm1(-double(transfer.table()[entry].extinction));
    };
    double most = 0;
    for (const OpacityPoint& point : transfer.opacity())
        most = std::max(most, point.opacity);
    if (!(most > 0)) most = 1;
    constexpr int kTicks = 4;
    for (int i = 0; i <= kTicks; ++i) {
        const double share = double(i) / kTicks;
        canvas.line({panel.high.x, panel.y(share)}, {panel.high.x + 4, panel.y(share)}, 1, kCurve);
        canvas.text({panel.high.x + 8, panel.y(share) + 7}, 0, fmt::format("{:.2g}", most * share), kCurve);
    }
    canvas.text({panel.high.x + 8, panel.low.y - 16}, 0.5, "opacity", kCurve);

    std::vector<glm::dvec2> curve;
    const int pixels = int(panel.high.x - panel.low.x);
    for (int i = 0; i <= pixels; ++i) {
        const double share = double(i) / pixels;
        const double magnitude = histogram.low + (histogram.high - histogram.low) * share;
        curve.emplace_back(panel.x(share), panel.y(opacity(magnitude) / most));
    }
    // A light edge keeps it apart from bars of its own colour.
    for (const auto& [width, color] : {std::pair(5.0, kPaper), std::pair(2.0, kCurve)}) {
        for (std::size_t i = 1; i < curve.size(); ++i)
            canvas.line(curve[i - 1], curve[i], width, color);
    }
}

} // namespace

std::string histogramPng(const TextureHistograms& histograms, const Look& look)
{
    Canvas canvas({1240, 460}, kPaper);
    const Panel left{{40, 60}, {552, 380}}, right{{630, 60}, {1142, 380}};

    drawBars(canvas, left, histograms.texture, [](std::size_t) { return kBars; });
    drawFrame(canvas, left, histograms.texture, "texture");

    const Histogram& magnitude = histograms.magnitude;
    const auto [low, high] = look.transfer.range();
    drawBars(canvas, right, magnitude, [&, low = low, high = high](std::size_t bin) {
        const double value = magnitude.low + (magnitude.high - magnitude.low) * (double(bin) + 0.5) / Histogram::kBins;
        return look.transfer.displayColor((value - low) / (high - low));
    });
    drawOpacity(canvas, right, magnitude, look.transfer);
    drawFrame(canvas, right, magnitude, "magnitude");
    return encodePng(canvas.size(), canvas.bytes());
}

} // namespace vdblic
