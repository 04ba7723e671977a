#include "vdblic/lic/coherence_report.h"

#include <cmath>
#include <numbers>

namespace vdblic {
namespace {

// The image, and the frame of the plot in it [pixels].
constexpr double kWidth = 680, kHeight = 420, kLeft = 64, kRight = 520, kTop = 24, kBottom = 364;
constexpr double kLowest = -0.4;

double xOf(double lag)
{
    return kLeft + (kRight - kLeft) * lag / kLongestLag;
}

double yOf(double correlation)
{
    return kBottom - (kBottom - kTop) * (std::max(correlation, kLowest) - kLowest) / (1 - kLowest);
}

/// How a curve looks, and what it is.
struct Style {
    const char *color, *dashes, *name;
};

std::string line(double x0, double y0, double x1, double y1, const char* style)
{
    return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" {}/>\n", x0, y0, x1, y1, style);
}

std::string text(double x, double y, const char* anchor, const std::string& what)
{
    return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor, what);
}

std::string axes()
{
    constexpr const char* kGrid = "stroke=\"#ddd\"";
    std::string svg;
    for (int lag = 0; lag <= int(kLongestLag); lag += 2) {
        svg += line(xOf(lag), kTop, xOf(lag), kBottom, kGrid);
        svg += text(xOf(lag), kBottom + 18, "middle", fmt::format("{}", lag));
    }
    for (int tenths = -4; tenths <= 10; tenths += 2) {
        const double correlation = tenths / 10.0;
        svg += line(kLeft, yOf(correlation), kRight, yOf(correlation), tenths == 0 ? "stroke=\"#888\"" : kGrid);
        svg += text(kLeft - 8, yOf(correlation) + 4, "end", fmt::format("{:.1f}", correlation));
    }
    const double threshold = yOf(1 / std::numbers::e);
    svg += line(kLeft, threshold, kRight, threshold, "stroke=\"#888\" stroke-dasharray=\"2 3\"");
    svg += text(kRight - 4, threshold - 4, "end", "1/e");
    svg += text((kLeft + kRight) / 2, kBottom + 40, "middle", "lag [voxels]");
    const double middle = (kTop + kBottom) / 2;
    svg += fmt::format("<text x=\"18\" y=\"{0:.1f}\" text-anchor=\"middle\" transform=\"rotate(-90 18 {0:.1f})\">"
                       "autocorrelation</text>\n",
                       middle);
    return svg;
}

std::string curve(const std::array<double, kLagCount>& values, const Style& style, int place)
{
    std::string points = fmt::format("{:.1f},{:.1f}", xOf(0), yOf(1));
    for (int lag = 0; lag < kLagCount; ++lag) {
        const double value = values[std::size_t(lag)];
        if (!std::isfinite(value)) break;
        points += fmt::format(" {:.1f},{:.1f}", xOf(double(kLagSpacing) * (lag + 1)), yOf(value));
    }
    const std::string look = fmt::format("fill=\"none\" stroke=\"{}\" stroke-width=\"2\" stroke-dasharray=\"{}\"",
                                         style.color, style.dashes);
    const double y = kTop + 12 + 24 * place;
    return fmt::format("<polyline points=\"{}\" {}/>\n", points, look) +
           line(kRight + 14, y, kRight + 44, y, look.c_str()) + text(kRight + 52, y + 4, "start", style.name);
}

} // namespace

std::string toSvg(const SequenceCoherence& coherence)
{
    std::string svg = fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
                                  "viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\" font-size=\"12\">\n"
                                  "<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n",
                                  kWidth, kHeight);
    svg += axes();
    svg += curve(coherence.raw.along, {"#1b6ca8", "none", "along, raw"}, 0);
    svg += curve(coherence.smoothed.along, {"#1b6ca8", "6 4", "along, smoothed"}, 1);
    svg += curve(coherence.raw.across, {"#c4501b", "none", "across, raw"}, 2);
    svg += curve(coherence.smoothed.across, {"#c4501b", "6 4", "across, smoothed"}, 3);
    return svg + "</svg>\n";
}

} // namespace vdblic
