#include "cli/option_names.h"

#include <algorithm>

namespace vdblic::cli {
namespace {

/// A parameter whose option is spelled differently.
struct Spelling {
    std::string_view parameter, option;
    std::string_view tool = {}; // empty: every tool
};

constexpr Spelling kSpellings[] = {
    {"box", "--bbox"},
    {"derived", "--with"},
    {"frame_spacing", "--dt or --fps"},
    {"life_span", "--life"},
    {"non_finite", "--nonfinite"},
    {"texture_name", "--texture", "vdblic_coherence"},
    {"world_box", "--bbox-world"},
};

bool isParameter(std::string_view word)
{
    return !word.empty() && word.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") == std::string_view::npos;
}

std::string optionOf(std::string_view parameter, std::string_view tool)
{
    for (const Spelling& spelling : kSpellings) {
        if (spelling.parameter == parameter && (spelling.tool.empty() || spelling.tool == tool))
            return std::string(spelling.option);
    }
    std::string option = "--" + std::string(parameter);
    std::replace(option.begin(), option.end(), '_', '-');
    return option;
}

} // namespace

std::string withOptionNames(std::string_view message, std::string_view tool)
{
    std::string result;
    for (std::size_t open = message.find('`'); open != std::string_view::npos; open = message.find('`')) {
        const std::size_t close = message.find('`', open + 1);
        const bool closed = close != std::string_view::npos;
        const std::string_view word = message.substr(open + 1, closed ? close - open - 1 : 0);
        result += message.substr(0, open);
        if (isParameter(word)) {
            result += optionOf(word, tool);
            message.remove_prefix(close + 1);
        } else {
            result += '`';
            message.remove_prefix(open + 1);
        }
    }
    result += message;
    return result;
}

} // namespace vdblic::cli
