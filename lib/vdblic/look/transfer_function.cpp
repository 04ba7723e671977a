#include "vdblic/look/transfer_function.h"

#include "vdblic/core/errors.h"
#include "vdblic/image/color_map.h"

#include <algorithm>
#include <bit>
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

const ScalarAxis& checked(const ScalarAxis& axis)
{
    axis.validate("opacity_scale");
    return axis;
}

} // namespace

TransferFunction::Scale::Scale(const ScalarAxis& axis)
    : mAxis(axis), mLow(float(axis.range[0])), mLowBits(std::bit_cast<int>(mLow)),
      mIsLog(axis.scale == ValueScale::kLogarithmic)
{
    const int bits = std::bit_cast<int>(float(axis.range[1])) - mLowBits;
    mPerEntry = float((kEntries - 1) / (mIsLog ? std::max(bits, 1) : axis.range[1] - axis.range[0]));
}

double TransferFunction::Scale::position(int entry) const
{
    const double share = double(entry) / (kEntries - 1);
    if (!mIsLog) return share;
    constexpr int kMantissa = 1 << 23, kBias = 127;
    const double bits = (mLowBits + entry / double(mPerEntry)) / kMantissa, power = std::floor(bits);
    return std::clamp(mAxis.position(std::ldexp(1 + bits - power, int(power) - kBias)), 0.0, 1.0);
}

TransferFunction::TransferFunction(const TransferParams& params)
    : mParams(checked(params)), mOpacityScale(checked(opacityAxis())), mColorScale(colorAxis()), mTable(kEntries),
      mExtinctions(kEntries), mVisibleBefore(kEntries + 1)
{
    const std::vector<ColorPoint> points = colors();
    for (int i = 0; i < kEntries; ++i) {
        const glm::dvec3 color = linearFromDisplay(colorAt(points, mColorScale.position(i)));
        const double extinction = -std::log1p(-std::min(opacityAt(mOpacityScale.position(i)), kMostOpacity));
        mTable[i] = {float(color.r), float(color.g), float(color.b), float(extinction)};
        mExtinctions[i] = mTable[i].extinction;
        mVisibleBefore[i + 1] = mVisibleBefore[i] + (mTable[i].extinction > 0);
    }
}

glm::dvec3 TransferFunction::displayColor(double position) const
{
    return colorAt(colors(), std::clamp(position, 0.0, 1.0));
}

double TransferFunction::opacityAt(double position) const
{
    return interpolate(mParams.opacity, std::clamp(position, 0.0, 1.0));
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

bool TransferFunction::contributesThroughout(float low, float high) const
{
    const auto [first, last] = entriesBetween(low, high);
    return mVisibleBefore[last + 1] - mVisibleBefore[first] == last + 1 - first;
}

} // namespace vdblic
