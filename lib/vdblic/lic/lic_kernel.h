#pragma once

#include <string_view>

namespace vdblic {

/// How the values along a streamline are weighted.
enum class LicKernel {
    kHann, ///< ½ + ½ cos(π s), s from 0 in the middle to 1 at the ends
    kBox,  ///< all alike
};

[[nodiscard]] LicKernel parseLicKernel(std::string_view text); ///< `hann` or `box`. @throws ParameterError
[[nodiscard]] std::string_view toString(LicKernel kernel);

} // namespace vdblic
