#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

/// The name that a mistyped word means: one that begins with it, else the one at Levenshtein's distance of at most a
/// third of its letters. Nothing if there is none.
[[nodiscard]] std::optional<std::string> nearestName(std::string_view word, const std::vector<std::string>& names);

} // namespace vdblic
