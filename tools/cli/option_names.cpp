#include "cli/option_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace vdblic::cli {
namespace {

bool isParameter(std::string_view word)
{
    return !word.empty() && word.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") == std::string_view::npos;
}

/// Parameters of vdblic_advect that messages of other tools may name, and their options.
constexpr std::pair<std::string_view, std::string_view> kOfAdvect[] = {
    {"box", "--bbox"}, {"mask", "--mask"}, {"world_box", "--bbox-world"}};

std::string optionOf(std::string_view key, const Parameters& parameters)
{
    const Parameter* const known = find(parameters, key);
    const auto* const ofAdvect =
        std::find_if(std::begin(kOfAdvect), std::end(kOfAdvect), [key](const auto& one) { return one.first == key; });
    if (!known && ofAdvect != std::end(kOfAdvect)) return fmt::format("{} of vdblic_advect", ofAdvect->second);
    const std::string option = (known ? *known : Parameter{key, {}}).option();
    return option.substr(option.rfind(',') + 1); // the long one
}

} // namespace

std::string withOptionNames(std::string_view message, const Parameters& parameters)
{
    std::string result;
    for (std::size_t open = message.find('`'); open != std::string_view::npos; open = message.find('`')) {
        const std::size_t close = message.find('`', open + 1);
        const bool closed = close != std::string_view::npos;
        const std::string_view word = message.substr(open + 1, closed ? close - open - 1 : 0);
        result += message.substr(0, open);
        if (isParameter(word)) {
            result += optionOf(word, parameters);
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
