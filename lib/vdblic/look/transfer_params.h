#pragma once

#include "vdblic/core/parameters.h"
#include "vdblic/image/color_map.h"
#include "vdblic/look/scalar_axis.h"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

/// A corner of a piecewise linear opacity curve.
struct OpacityPoint {
    double position; ///< 0 to 1 over the driver's range
    double opacity;  ///< of one voxel, 0 to 1
};

/// Parse `0:0,0.4:0.05,1:0.8` into points of position and opacity. @throws ParameterError
[[nodiscard]] std::vector<OpacityPoint> parseOpacity(std::string_view text);
/// The text that parseOpacity() reads back.
[[nodiscard]] std::string opacityText(const std::vector<OpacityPoint>& points);
/// Parse `0:#102040,1:#fff6d5` into points of position and display (sRGB) colour, 8 bits a channel in hexadecimal
/// digits. @throws ParameterError
[[nodiscard]] std::vector<ColorPoint> parseColors(std::string_view text);

/// The text that parseColors() reads back.
[[nodiscard]] std::string colorsText(const std::vector<ColorPoint>& points);

/// How scalars that grids beside the texture hold become colour and opacity. One scalar may do both.
struct TransferParams {
    std::string colorMap = "ember";
    std::vector<ColorPoint> colors{}; ///< by rising position, in place of the colour map
    /// Opacity of one voxel of full texture, by rising position; empty: chosen from the frames.
    std::vector<OpacityPoint> opacity{};
    /// Values at positions 0 and 1 of the scalar that colours [unit of its grid]; unset: percentiles of the frames.
    std::optional<std::array<double, 2>> range{};
    /// The same for the scalar that opacity follows; unset: `range` if one scalar does both, else percentiles.
    std::optional<std::array<double, 2>> opacityRange{};
    /// Of the scalar that colour follows, and of the one that opacity follows; unset: linear, but colorScale if they
    /// share a range.
    ValueScale colorScale = ValueScale::kLinear;
    std::optional<ValueScale> opacityScale{};
    std::string unit{}, opacityUnit{}; ///< of the two scalars, as pictures show them
    /// Names of the values 0, 1, 2 and so on, where the scalar for colour is a class number. 0 is unclassified.
    std::vector<std::string> kinds{};

    /// Whether a scalar that both colour and opacity follow has one range for both.
    [[nodiscard]] bool sharesRange() const { return !opacityRange && !opacityScale; }
    /// @throws ParameterError
    void validate() const;
};
[[nodiscard]] Parameters parametersOf(TransferParams& params);

} // namespace vdblic
