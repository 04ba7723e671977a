#pragma once

#include <glm/vec3.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

/// The time of a frame, if its file has it.
struct FrameClock {
    std::optional<double> time; ///< [s]
    std::optional<double> dt;   ///< to the next frame [s]; times are shown as finely as that
    std::string start{};        ///< date of time 0, ISO 8601
    double longest = 0;         ///< time of the sequence [s], without sign: all its times are written alike
};

/// A date and time of day where the file has a start, else days, hours, minutes and seconds as fine as the spacing
/// needs them, or a part of a second; empty without a time. All frames of a sequence have the same units and as many
/// digits.
[[nodiscard]] std::string clockText(const FrameClock& clock);

/// Whether the axes are probably east, north and up: a date and metres, as vdblic_import writes them for
/// weather and oceans, or heights that are exaggerated and ten minutes or more between frames.
[[nodiscard]] bool isGeographic(const FrameClock& clock, const std::string& lengthUnit, const glm::dvec3& stretch);

/// A whole number with spaces as wide as digits before it. @param largest number that is to have no space
[[nodiscard]] std::string paddedText(std::int64_t number, std::int64_t largest);

/// A length with its unit: "200 km", "5 mm". @param unit of it; empty: unknown
[[nodiscard]] std::string lengthText(double length, const std::string& unit);

/// The unit of a scalar: as given, else by its name, if that has one; empty: unknown.
[[nodiscard]] std::string scalarUnit(const std::string& name, const std::string& unit);
/// The field's term for a scalar, with a unit if there is one: "speed [m/s]".
[[nodiscard]] std::string scalarTitle(const std::string& name, const std::string& unit);

/// A factor that numbers on axes are shown in, so that they stay short.
struct AxisUnit {
    double factor = 1;
    std::string text; ///< "km", "10³"; empty: none
};
/// @param largest magnitude of a number on them  @param unit of the numbers; empty: unknown
[[nodiscard]] AxisUnit axisUnit(double largest, const std::string& unit);

/// Round numbers between two bounds, about `wanted` of them. @param step receives their distance
[[nodiscard]] std::vector<double> roundNumbers(double low, double high, int wanted, double& step);
/// A number with as many decimals as its step needs.
[[nodiscard]] std::string tickText(double value, double step);

} // namespace vdblic
