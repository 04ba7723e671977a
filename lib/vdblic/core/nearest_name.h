#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

/// The name meant by a mistyped word: one that begins with it, else the nearest within a Levenshtein distance of a
/// third of its letters, else nothing.
[[nodiscard]] std::optional<std::string> nearestName(std::string_view word, const std::vector<std::string>& names);

} // namespace vdblic
