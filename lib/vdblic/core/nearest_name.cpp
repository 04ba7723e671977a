#include "vdblic/core/nearest_name.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace vdblic {
namespace {

/// Levenshtein's distance: the least number of letters to insert, delete or replace.
std::size_t letterDistance(std::string_view a, std::string_view b)
{
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t(0));
    for (const char letter : a) {
        std::size_t diagonal = row[0]++;
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t above = row[j + 1];
            row[j + 1] = std::min({above + 1, row[j] + 1, diagonal + (letter == b[j] ? 0 : 1)});
            diagonal = above;
        }
    }
    return row.back();
}

} // namespace

std::optional<std::string> nearestName(std::string_view word, const std::vector<std::string>& names)
{
    const auto distance = [&](const std::string& name) {
        return name.starts_with(word) ? 0 : letterDistance(word, name);
    };
    const auto nearest = std::min_element(names.begin(), names.end(),
                                          [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
    if (nearest == names.end() || distance(*nearest) > word.size() / 3) return std::nullopt;
    return *nearest;
}

} // namespace vdblic
