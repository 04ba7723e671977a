#include "vdblic/coherence/coherence_report.h"
#include "vdblic/core/errors.h"

#include <cairo-svg.h>
#include <cairo.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <exception>
#include <memory>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

// The image, and the frame of the plot in it [pixels].
constexpr double kWidth = 680, kHeight = 420, kLeft = 64, kRight = 520, kTop = 24, kBottom = 364;
constexpr double kLowest = -0.4; // correlation at the bottom

double xOf(double lag)
{
    return kLeft + (kRight - kLeft) * lag / kLongestLag;
}

double yOf(double correlation)
{
    return kBottom - (kBottom - kTop) * (std::max(correlation, kLowest) - kLowest) / (1 - kLowest);
}

struct Colour {
    double red, green, blue;
};
constexpr Colour kBlack{0, 0, 0}, kWhite{1, 1, 1}, kGridGrey{0.87, 0.87, 0.87}, kAxisGrey{0.53, 0.53, 0.53};
constexpr Colour kBlue{0.106, 0.424, 0.659}, kOrange{0.769, 0.314, 0.106};

/// How a line is drawn; no dashes: solid.
struct Stroke {
    Colour colour = kGridGrey;
    double width = 1;
    std::array<double, 2> dashes{};
};
constexpr Stroke kGridLine, kAxisLine{kAxisGrey}, kThresholdLine{kAxisGrey, 1, {2, 3}};

/// Where a text stands relative to its position.
enum class Anchor { kStart, kMiddle, kEnd };

cairo_status_t append(void* text, const unsigned char* bytes, unsigned count)
{
    try {
        static_cast<std::string*>(text)->append(reinterpret_cast<const char*>(bytes), count);
        return CAIRO_STATUS_SUCCESS;
    } catch (const std::exception&) { // must not pass through Cairo, which is C
        return CAIRO_STATUS_WRITE_ERROR;
    }
}

/// A drawing on Cairo's SVG surface [pixels, y downwards].
class Drawing {
  public:
    Drawing()
        : mSurface(cairo_svg_surface_create_for_stream(append, &mSvg, kWidth, kHeight), &cairo_surface_destroy),
          mCairo(cairo_create(mSurface.get()), &cairo_destroy)
    {
        cairo_svg_surface_set_document_unit(mSurface.get(), CAIRO_SVG_UNIT_PX);
        cairo_select_font_face(mCairo.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
        cairo_set_font_size(mCairo.get(), 12);
        setColour(kWhite);
        cairo_paint(mCairo.get());
    }
    Drawing(const Drawing&) = delete; // the surface writes to mSvg
    Drawing& operator=(const Drawing&) = delete;

    struct Point {
        double x, y;
    };

    void line(std::span<const Point> points, const Stroke& stroke)
    {
        for (const Point& point : points)
            cairo_line_to(mCairo.get(), point.x, point.y);
        setColour(stroke.colour);
        cairo_set_line_width(mCairo.get(), stroke.width);
        cairo_set_dash(mCairo.get(), stroke.dashes.data(), stroke.dashes[0] > 0 ? int(stroke.dashes.size()) : 0, 0);
        cairo_stroke(mCairo.get());
    }
    void line(Point start, Point end, const Stroke& stroke) { line(std::array{start, end}, stroke); }

    /// @param angle clockwise [radians]
    void text(Point at, Anchor anchor, const std::string& what, double angle = 0)
    {
        cairo_text_extents_t extents;
        cairo_text_extents(mCairo.get(), what.c_str(), &extents);
        const double before = anchor == Anchor::kStart ? 0 : anchor == Anchor::kMiddle ? 0.5 : 1;
        cairo_save(mCairo.get());
        cairo_translate(mCairo.get(), at.x, at.y);
        cairo_rotate(mCairo.get(), angle);
        cairo_move_to(mCairo.get(), -before * extents.x_advance, 0);
        setColour(kBlack);
        cairo_show_text(mCairo.get(), what.c_str());
        cairo_restore(mCairo.get());
        cairo_new_path(mCairo.get());
    }

    /// The drawing as SVG; nothing can be drawn after this. @throws OutputError
    [[nodiscard]] std::string finish()
    {
        const cairo_status_t drawn = cairo_status(mCairo.get());
        cairo_surface_finish(mSurface.get());
        for (const cairo_status_t status : {drawn, cairo_surface_status(mSurface.get())}) {
            if (status != CAIRO_STATUS_SUCCESS)
                throw OutputError(fmt::format("the plot cannot be drawn: {}", cairo_status_to_string(status)));
        }
        // Cairo counts the surfaces of the process; without the count, equal figures give equal files.
        const std::size_t id = mSvg.find(" id=\"surface");
        if (id != std::string::npos) mSvg.erase(id, mSvg.find('>', id) - id);
        return std::move(mSvg);
    }

  private:
    void setColour(const Colour& colour) { cairo_set_source_rgb(mCairo.get(), colour.red, colour.green, colour.blue); }

    std::string mSvg;
    std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> mSurface;
    std::unique_ptr<cairo_t, decltype(&cairo_destroy)> mCairo;
};

void drawAxes(Drawing& drawing)
{
    for (int lag = 0; lag <= int(kLongestLag); lag += 2) {
        drawing.line({xOf(lag), kTop}, {xOf(lag), kBottom}, kGridLine);
        drawing.text({xOf(lag), kBottom + 18}, Anchor::kMiddle, fmt::format("{}", lag));
    }
    for (int tenths = -4; tenths <= 10; tenths += 2) {
        const double correlation = tenths / 10.0, y = yOf(correlation);
        drawing.line({kLeft, y}, {kRight, y}, tenths == 0 ? kAxisLine : kGridLine);
        drawing.text({kLeft - 8, y + 4}, Anchor::kEnd, fmt::format("{:.1f}", correlation));
    }
    const double threshold = yOf(1 / std::numbers::e);
    drawing.line({kLeft, threshold}, {kRight, threshold}, kThresholdLine);
    drawing.text({kRight - 4, threshold - 4}, Anchor::kEnd, "1/e");
    drawing.text({(kLeft + kRight) / 2, kBottom + 40}, Anchor::kMiddle, "lag [voxels of the velocity]");
    drawing.text({18, (kTop + kBottom) / 2}, Anchor::kMiddle, "autocorrelation", -std::numbers::pi / 2);
}

/// @param row of the legend, from the top
void drawCurve(Drawing& drawing, const std::vector<double>& lags, const std::vector<double>& values,
               const Stroke& stroke, int row, const std::string& name)
{
    std::vector<Drawing::Point> points = {{xOf(0), yOf(1)}};
    for (std::size_t lag = 0; lag < lags.size() && std::isfinite(values[lag]); ++lag)
        points.push_back({xOf(lags[lag]), yOf(values[lag])});
    drawing.line(points, stroke);
    const double y = kTop + 12 + 24 * row;
    drawing.line({kRight + 14, y}, {kRight + 44, y}, stroke);
    drawing.text({kRight + 52, y + 4}, Anchor::kStart, name);
}

} // namespace

std::string toSvg(const SequenceCoherence& coherence)
{
    Drawing drawing;
    drawAxes(drawing);
    constexpr std::array<double, 2> kSolid{}, kDashed{6, 4};
    drawCurve(drawing, coherence.lags, coherence.raw.along, {kBlue, 2, kSolid}, 0, "along, raw");
    drawCurve(drawing, coherence.lags, coherence.smoothed.along, {kBlue, 2, kDashed}, 1, "along, smoothed");
    drawCurve(drawing, coherence.lags, coherence.raw.across, {kOrange, 2, kSolid}, 2, "across, raw");
    drawCurve(drawing, coherence.lags, coherence.smoothed.across, {kOrange, 2, kDashed}, 3, "across, smoothed");
    return drawing.finish();
}

} // namespace vdblic
