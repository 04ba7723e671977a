#pragma once

#include "vdblic/core/names.h"

#include <array>
#include <string_view>

namespace vdblic {

/// How the values of a range are spread over positions.
enum class ValueScale { kLinear, kLogarithmic };
template<>
inline constexpr auto kNames<ValueScale> = std::to_array<std::string_view>({"linear", "log"});

/// Positions along a scalar's range: 0 at its low end, 1 at its high end.
struct ScalarAxis {
    static constexpr double kMostValue = 1e30;   ///< scalars are kept in single precision
    static constexpr double kLeastValue = 1e-30; ///< of a logarithmic scale

    std::array<double, 2> range{0, 1};
    ValueScale scale = ValueScale::kLinear;

    /// Not clamped; −∞ for values that a logarithmic scale does not have.
    [[nodiscard]] double position(double value) const;
    [[nodiscard]] double value(double position) const;
    /// @param scaleName the parameter that sets the scale, for the message  @throws ParameterError
    void validate(std::string_view scaleName) const;
};

} // namespace vdblic
