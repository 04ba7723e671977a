#pragma once

#include "vdblic/render/color_map.h"

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

/// How the driver, the scalar that a grid beside the texture holds, becomes colour and opacity.
struct TransferParams {
    static constexpr double kMostValue = 1e30; ///< of the driver, which is kept in single precision

    std::string colorMap = "turbo";
    std::vector<ColorPoint> colors{}; ///< by rising position, in place of the colour map
    /// Opacity of one voxel of full texture, by rising position; empty: chosen from the frames.
    std::vector<OpacityPoint> opacity{};
    /// Values of the driver at positions 0 and 1 [unit of its grid]; unset: percentiles of the frames.
    std::optional<std::array<double, 2>> range{};

    /// @throws ParameterError
    void validate() const;
};

} // namespace vdblic
