#include "vdblic/look/scalar_axis.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace vdblic {

double ScalarAxis::position(double value) const
{
    const auto& [low, high] = range;
    if (scale == ValueScale::kLinear) return (value - low) / (high - low);
    return value > 0 ? std::log(value / low) / std::log(high / low) : -std::numeric_limits<double>::infinity();
}

double ScalarAxis::value(double position) const
{
    const auto& [low, high] = range;
    return scale == ValueScale::kLinear ? low + (high - low) * position : low * std::pow(high / low, position);
}

void ScalarAxis::validate(std::string_view scaleName) const
{
    const auto& [low, high] = range;
    if (!(std::abs(low) <= kMostValue) || !(std::abs(high) <= kMostValue) || !(low < high)) {
        throw ParameterError(
            fmt::format("range {} to {} must be two rising numbers of at most {}", low, high, kMostValue));
    }
    if (scale == ValueScale::kLogarithmic && low < kLeastValue) {
        throw ParameterError(fmt::format("range {} to {} cannot be logarithmic: it must begin above 0, at {} or more; "
                                         "raise its low end or make `{}` linear",
                                         low, high, kLeastValue, scaleName));
    }
}

} // namespace vdblic
