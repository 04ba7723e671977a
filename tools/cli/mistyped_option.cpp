#include "cli/mistyped_option.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <limits>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic::cli {
namespace {

/// Levenshtein's distance: the least number of letters to insert, delete or replace.
std::size_t distanceOf(std::string_view a, std::string_view b)
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

std::vector<std::string> longNames(const CLI::App& app)
{
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options()) {
        for (const std::string& name : option->get_lnames())
            names.push_back("--" + name);
    }
    return names;
}

} // namespace

void checkOptions(const CLI::App& app, int argc, char** argv)
{
    const std::vector<std::string> names = longNames(app);
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        if (argument == "--") return;
        if (!argument.starts_with("--") || std::isalpha(static_cast<unsigned char>(argument[2])) == 0) continue;
        const std::string option = argument.substr(0, argument.find('='));
        if (std::find(names.begin(), names.end(), option) != names.end()) continue;
        const auto nearer = [&](const std::string& a, const std::string& b) {
            // A beginning of a name is nearest: --frame for --frames.
            const auto distance = [&](const std::string& name) {
                return name.starts_with(option) ? 0 : distanceOf(option, name);
            };
            return distance(a) < distance(b);
        };
        const std::string nearest = *std::min_element(names.begin(), names.end(), nearer);
        const bool isNear = nearest.starts_with(option) || distanceOf(option, nearest) <= option.size() / 3;
        throw CLI::ExtrasError(fmt::format("there is no option {:.60}{}", option,
                                           isNear ? fmt::format("; {} is one", nearest) : std::string()),
                               CLI::ExitCodes::ExtrasError);
    }
}

} // namespace vdblic::cli
