#include "vdblic/io/pattern_advice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <regex>
#include <system_error>
#include <vector>

namespace vdblic {
namespace {

std::vector<std::string> namesIn(const std::filesystem::path& folder)
{
    std::vector<std::string> names;
    std::error_code error;
    for (std::filesystem::directory_iterator entry(folder.empty() ? "." : folder, error), end; !error && entry != end;
         entry.increment(error))
        names.push_back(entry->path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

bool isDigit(char c)
{
    return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

/// The first .vdb file in a folder whose name ends in a number; empty if there is none.
std::string numberedFile(const std::filesystem::path& folder)
{
    for (const std::string& name : namesIn(folder)) {
        const std::filesystem::path path(name);
        const std::string stem = path.stem().string();
        if (path.extension() == ".vdb" && !stem.empty() && isDigit(stem.back())) return name;
    }
    return {};
}

} // namespace

std::string likelyPattern(const std::filesystem::path& folder, const std::string& prefix, const std::string& suffix,
                          const std::string& only)
{
    for (const std::string& name : only.empty() ? namesIn(folder) : std::vector<std::string>{only}) {
        if (name.size() <= prefix.size() + suffix.size() || !name.starts_with(prefix) || !name.ends_with(suffix))
            continue;
        const std::string digits = name.substr(prefix.size(), name.size() - prefix.size() - suffix.size());
        if (!std::all_of(digits.begin(), digits.end(), isDigit)) continue;
        const std::string field = digits.size() > 1 ? fmt::format("%0{}d", digits.size()) : "%d";
        return (folder / fmt::format("{}{}{}", prefix, field, suffix)).string();
    }
    return {};
}

std::string patternAdvice(const std::filesystem::path& pattern)
{
    std::error_code ignored;
    if (std::filesystem::is_directory(pattern, ignored)) {
        const std::string file = numberedFile(pattern);
        if (file.empty()) return "it is a folder; name a file or a pattern such as name.%04d.vdb";
        static const std::regex number(R"((\d+)(\.vdb)$)");
        std::smatch match;
        std::regex_search(file, match, number);
        return fmt::format("it is a folder holding {} ...; write {}", file,
                           likelyPattern(pattern, match.prefix(), match[2]));
    }
    const std::string name = pattern.filename().string();
    static const std::regex wrongField(R"(\*+|\?+|%\d*[diu])");
    std::smatch match;
    if (!std::regex_search(name, match, wrongField)) return {};
    std::string meant = likelyPattern(pattern.parent_path(), match.prefix(), match.suffix());
    if (meant.empty())
        meant = (pattern.parent_path() / (match.prefix().str() + "%04d" + match.suffix().str())).string();
    return fmt::format("'{}' is no frame field; write {}", match.str(), meant);
}

} // namespace vdblic
