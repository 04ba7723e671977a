#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace vdblic {

/// The most frames a sequence may select; a larger list is probably a typing error.
inline constexpr std::size_t kMaxFrames = 999'999;

/// Parse `1-100`, `1-100x2`, `1,5,9-20`, with negative numbers allowed, into ascending unique frames.
/// @throws ParameterError on anything else, a descending range, or more than kMaxFrames frames
[[nodiscard]] std::vector<std::int64_t> parseFrameList(std::string_view text);

} // namespace vdblic
