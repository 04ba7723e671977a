#include "vdblic/render/transfer_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

namespace vdblic {
namespace {

double parseNumber(std::string_view text, std::string_view all)
{
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) {
        throw ParameterError(
            fmt::format("opacity '{}': '{}' is not a number; write points as 0:0,0.5:0.1,1:0.8", all, text));
    }
    return value;
}

void checkRange(const std::array<double, 2>& range)
{
    const auto& [low, high] = range;
    constexpr double kMost = TransferParams::kMostValue;
    if (!(std::abs(low) <= kMost) || !(std::abs(high) <= kMost) || !(low < high)) {
        throw ParameterError(fmt::format("range {} to {} must be two rising numbers of at most {}", low, high, kMost));
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

} // namespace

std::vector<OpacityPoint> parseOpacity(std::string_view text)
{
    std::vector<OpacityPoint> points;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        const std::string_view part = text.substr(begin, end - begin);
        const std::size_t colon = part.find(':');
        if (colon == std::string_view::npos) {
            throw ParameterError(fmt::format("opacity '{}': '{}' is not POSITION:OPACITY", text, part));
        }
        points.push_back({parseNumber(part.substr(0, colon), text), parseNumber(part.substr(colon + 1), text)});
        begin = end + 1;
    }
    checkOpacity(points);
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

void TransferParams::validate() const
{
    (void)colorMapPoints(colorMap);
    checkOpacity(opacity);
    double previous = 0;
    for (const auto& [position, color] : colors) {
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
    if (range) checkRange(*range);
    if (opacityRange) checkRange(*opacityRange);
}

} // namespace vdblic
