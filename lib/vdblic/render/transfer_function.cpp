#include "vdblic/render/transfer_function.h"

#include "vdblic/core/errors.h"
#include "vdblic/render/color_map.h"

#include <algorithm>
#include <cmath>

namespace vdblic {
namespace {

// An opacity of 1 would have an infinite optical depth.
constexpr double kMostOpacity = 1 - 1e-6;

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

const TransferParams& checked(const TransferParams& params)
{
    params.validate();
    if (params.opacity.empty()) throw ParameterError("a transfer function needs at least one opacity point");
    if (!params.range) throw ParameterError("a transfer function needs a range");
    return params;
}

} // namespace

TransferFunction::TransferFunction(const TransferParams& params)
    : mParams(checked(params)), mOpacityScale(opacityRange()), mColorScale(range()), mTable(kEntries),
      mExtinctions(kEntries), mVisibleBefore(kEntries + 1)
{
    const std::vector<ColorPoint> points = colors();
    for (int i = 0; i < kEntries; ++i) {
        const double position = double(i) / (kEntries - 1);
        const glm::dvec3 color = linearFromDisplay(colorAt(points, position));
        const double extinction = -std::log1p(-std::min(interpolate(params.opacity, position), kMostOpacity));
        mTable[i] = {float(color.r), float(color.g), float(color.b), float(extinction)};
        mExtinctions[i] = mTable[i].extinction;
        mVisibleBefore[i + 1] = mVisibleBefore[i] + (mTable[i].extinction > 0);
    }
}

glm::dvec3 TransferFunction::displayColor(double position) const
{
    return colorAt(colors(), std::clamp(position, 0.0, 1.0));
}

std::array<int, 2> TransferFunction::entriesBetween(float low, float high) const
{
    // Interpolation may round past its corners' values, hence one more entry at each end.
    const Int8 ends = entries(Float8{low, high});
    return {std::max(ends[0] - 1, 0), std::min(ends[1] + 1, kEntries - 1)};
}

bool TransferFunction::contributes(float low, float high) const
{
    const auto [first, last] = entriesBetween(low, high);
    return mVisibleBefore[last + 1] > mVisibleBefore[first];
}

float TransferFunction::mostExtinction(float low, float high) const
{
    const auto [first, last] = entriesBetween(low, high);
    return *std::max_element(mExtinctions.begin() + first, mExtinctions.begin() + last + 1);
}

} // namespace vdblic
