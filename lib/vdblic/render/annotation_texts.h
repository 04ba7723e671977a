#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

/// When a frame is, as far as its file tells.
struct FrameClock {
    std::optional<double> time; ///< [s]
    std::optional<double> dt;   ///< to the next frame [s]; times are shown as finely as that
    std::string start{};        ///< date of time 0, ISO 8601
};

/// A date and time of day where the file has a start, else hours, minutes and seconds, or a part of a second; empty
/// without a time. What a second is divided into is the same for all frames of one spacing.
[[nodiscard]] std::string clockText(const FrameClock& clock);

/// The name of a scalar with its unit: "speed [m/s]". @param unit empty: by the name, if that has one
[[nodiscard]] std::string scalarTitle(const std::string& name, const std::string& unit);

/// A factor that numbers on an axis are shown in, so that they stay short.
struct AxisUnit {
    double factor = 1;
    std::string text; ///< "km", "10³"; empty: none
};
/// @param largest magnitude of a number on the axis  @param unit of the numbers; empty: unknown
[[nodiscard]] AxisUnit axisUnit(double largest, const std::string& unit);

/// Round numbers between two bounds, about `wanted` of them. @param step receives their distance
[[nodiscard]] std::vector<double> roundNumbers(double low, double high, int wanted, double& step);
/// A number with as many decimals as its step needs.
[[nodiscard]] std::string tickText(double value, double step);

} // namespace vdblic
