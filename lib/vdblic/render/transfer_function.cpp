#include "vdblic/render/transfer_function.h"

#include "vdblic/core/errors.h"
#include "vdblic/render/color_map.h"

#include <charconv>
#include <cmath>

namespace vdblic {
namespace {

// An opacity of 1 has an infinite optical depth; this is as good as one.
constexpr double kMostOpacity = 1 - 1e-6;

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

double interpolate(const std::vector<OpacityPoint>& points, double position)
{
    const auto after = std::upper_bound(points.begin(), points.end(), position,
                                        [](double p, const OpacityPoint& point) { return p < point.position; });
    if (after == points.begin()) return after->opacity;
    const auto before = std::prev(after);
    if (after == points.end()) return before->opacity;
    const double fraction = (position - before->position) / (after->position - before->position);
    return before->opacity + (after->opacity - before->opacity) * fraction;
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
    if (!range) return;
    const auto& [low, high] = *range;
    constexpr double kMost = 1e30; // magnitudes are single precision
    if (!(std::abs(low) <= kMost) || !(std::abs(high) <= kMost) || !(low < high)) {
        throw ParameterError(fmt::format("range {} to {} must be two rising numbers of at most {}", low, high, kMost));
    }
}

TransferFunction::TransferFunction(const TransferParams& params)
    : mParams(params), mTable(kEntries), mExtinctions(kEntries), mOpaqueBefore(kEntries + 1)
{
    params.validate();
    if (params.opacity.empty()) throw ParameterError("a transfer function needs at least one opacity point");
    if (!params.range) throw ParameterError("a transfer function needs a range");
    const auto& [low, high] = *params.range;
    mLow = float(low);
    mScale = float((kEntries - 1) / (high - low));
    const std::vector<ColorPoint> colors = params.colors.empty() ? colorMapPoints(params.colorMap) : params.colors;
    for (int i = 0; i < kEntries; ++i) {
        const double position = double(i) / (kEntries - 1);
        const glm::dvec3 color = linearFromDisplay(colorAt(colors, position));
        const double extinction = -std::log1p(-std::min(interpolate(params.opacity, position), kMostOpacity));
        mTable[i] = {float(color.r), float(color.g), float(color.b), float(extinction)};
        mExtinctions[i] = mTable[i].extinction;
        mOpaqueBefore[i + 1] = mOpaqueBefore[i] + (mTable[i].extinction > 0);
    }
}

glm::dvec3 TransferFunction::displayColor(double position) const
{
    return colorAt(mParams.colors.empty() ? colorMapPoints(mParams.colorMap) : mParams.colors,
                   std::clamp(position, 0.0, 1.0));
}

bool TransferFunction::contributes(float low, float high) const
{
    // One entry more at each end: interpolation may round past its corners' values.
    const Int8 ends = entries(Float8{low, high});
    const int first = std::max(ends[0] - 1, 0);
    const int last = std::min(ends[1] + 1, kEntries - 1);
    return mOpaqueBefore[last + 1] > mOpaqueBefore[first];
}

} // namespace vdblic
