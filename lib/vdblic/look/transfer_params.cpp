#include "vdblic/look/transfer_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

namespace vdblic {
namespace {

/// The text form of a curve's points.
struct PointSyntax {
    const char *name, *value, *example;
};
constexpr PointSyntax kOpacitySyntax{"opacity", "OPACITY", "0:0,0.5:0.1,1:0.8"};
constexpr PointSyntax kColorSyntax{"colours", "#RRGGBB", "0:#102040,0.5:#e2581a,1:#fff6d5"};

double parseNumber(std::string_view text, std::string_view all, const PointSyntax& syntax)
{
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) {
        throw ParameterError(
            fmt::format("{} '{}': '{}' is not a number; write points as {}", syntax.name, all, text, syntax.example));
    }
    return value;
}

glm::dvec3 parseColor(std::string_view text, std::string_view all)
{
    unsigned value = 0;
    const bool hasSize = text.size() == 7 && text[0] == '#';
    const char* const begin = text.data() + (hasSize ? 1 : 0);
    const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value, 16);
    if (!hasSize || error != std::errc{} || end != text.data() + text.size()) {
        throw ParameterError(fmt::format("colours '{}': '{}' is not a colour #RRGGBB in hexadecimal digits; write "
                                         "points as {}",
                                         all, text, kColorSyntax.example));
    }
    return glm::dvec3(value >> 16, value >> 8 & 255, value & 255) / 255.0;
}

/// Cut `POSITION:VALUE,...` into points. @param visit called with each point's two texts
template<typename Visit>
void forPoints(std::string_view text, const PointSyntax& syntax, const Visit& visit)
{
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        const std::string_view part = text.substr(begin, end - begin);
        const std::size_t colon = part.find(':');
        if (colon == std::string_view::npos) {
            throw ParameterError(fmt::format("{} '{}': '{}' is not POSITION:{}; write points as {}", syntax.name, text,
                                             part, syntax.value, syntax.example));
        }
        visit(part.substr(0, colon), part.substr(colon + 1));
        begin = end + 1;
    }
}

void checkOpacity(const std::vector<OpacityPoint>& points)
{
    double previous = 0;
    for (const OpacityPoint& point : points) {
        if (!(point.position >= previous && point.position <= 1)) {
            throw ParameterError(fmt::format(
                "opacity position {} must be between 0 and 1 and not before the previous one", point.position));
        }
        if (!(point.opacity >= 0 && point.opacity <= 1)) {
            throw ParameterError(
                fmt::format("opacity {} at position {} must be between 0 and 1", point.opacity, point.position));
        }
        previous = point.position;
    }
}

void checkColors(const std::vector<ColorPoint>& points)
{
    double previous = 0;
    for (const auto& [position, color] : points) {
        if (!(position >= previous && position <= 1)) {
            throw ParameterError(
                fmt::format("colour position {} must be between 0 and 1 and not before the previous one", position));
        }
        for (int channel = 0; channel < 3; ++channel) {
            if (!(color[channel] >= 0 && color[channel] <= 1)) {
                throw ParameterError(
                    fmt::format("colour value {} at position {} must be between 0 and 1", color[channel], position));
            }
        }
        previous = position;
    }
}

} // namespace

std::vector<OpacityPoint> parseOpacity(std::string_view text)
{
    std::vector<OpacityPoint> points;
    forPoints(text, kOpacitySyntax, [&](std::string_view position, std::string_view opacity) {
        points.push_back({parseNumber(position, text, kOpacitySyntax), parseNumber(opacity, text, kOpacitySyntax)});
    });
    checkOpacity(points);
    return points;
}

std::vector<ColorPoint> parseColors(std::string_view text)
{
    std::vector<ColorPoint> points;
    forPoints(text, kColorSyntax, [&](std::string_view position, std::string_view color) {
        points.push_back({parseNumber(position, text, kColorSyntax), parseColor(color, text)});
    });
    checkColors(points);
    return points;
}

std::string opacityText(const std::vector<OpacityPoint>& points)
{
    std::string text;
    for (const OpacityPoint& point : points) {
        text += fmt::format("{}{}:{}", text.empty() ? "" : ",", point.position, point.opacity);
    }
    return text;
}

Parameters parametersOf(TransferParams& params)
{
    const auto setMap = [&params](const Words& words) {
        params.colorMap = words[0];
        params.colors.clear();
    };
    Parameter map = parameter("colormap", "Colours over the range.", WordType::kText, 1, setMap,
                              [&params] { return Words{params.colorMap}; }, {.words = "NAME"});
    map.choices = colorMapNames();
    const auto wordsOf = [](std::string text) { return text.empty() ? Words{} : Words{std::move(text)}; };
    return {
        map,
        parameter(
            "colors", "Colours of one's own over the range, e.g. 0:#102040,0.5:#e2581a,1:#fff6d5, as displayed.",
            WordType::kText, 1, [&params](const Words& words) { params.colors = parseColors(words[0]); },
            [&params, wordsOf] { return wordsOf(colorsText(params.colors)); },
            {.words = "POSITION:#RRGGBB,...", .excludes = "colormap"}),
        parameter(
            "opacity",
            "Opacity of one voxel over the range, e.g. 0:0,0.4:0.05,1:0.8. By default it rises with the values, scaled "
            "so that one sees into the volume.",
            WordType::kText, 1, [&params](const Words& words) { params.opacity = parseOpacity(words[0]); },
            [&params, wordsOf] { return wordsOf(opacityText(params.opacity)); }, {.words = "POSITION:OPACITY,..."}),
        parameter("range", "Values at positions 0 and 1 of the range; percentiles of the frames by default.",
                  params.range, {.words = "LO HI"}),
        parameter("opacity_range",
                  "The same of the grid that opacity follows; that of the colours if one grid does both.",
                  params.opacityRange, {.words = "LO HI"}),
        parameter("color_scale", "How the values of the range are spread over positions.", params.colorScale,
                  {.words = "SCALE"}),
        parameter("opacity_scale",
                  "The same of the grid that opacity follows; linear by default, but as the colours' if one grid with "
                  "one range does both.",
                  params.opacityScale, {.words = "SCALE"}),
    };
}

std::string colorsText(const std::vector<ColorPoint>& points)
{
    std::string text;
    for (const ColorPoint& point : points) {
        const auto byte = [&](int channel) { return int(std::lround(255 * point.color[channel])); };
        text +=
            fmt::format("{}{}:#{:02x}{:02x}{:02x}", text.empty() ? "" : ",", point.position, byte(0), byte(1), byte(2));
    }
    return text;
}

void TransferParams::validate() const
{
    (void)colorMapPoints(colorMap);
    checkOpacity(opacity);
    checkColors(colors);
    if (range) ScalarAxis{*range, colorScale}.validate("color_scale");
    if (opacityRange) ScalarAxis{*opacityRange, opacityScale.value_or(ValueScale::kLinear)}.validate("opacity_scale");
}

} // namespace vdblic
