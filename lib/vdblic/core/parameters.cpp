#include "vdblic/core/parameters.h"

#include "vdblic/core/errors.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <system_error>

namespace vdblic {
namespace {

/// The separator of a value's words in one text.
const char* separator(const Parameter& parameter)
{
    return parameter.isList() && parameter.type == WordType::kText ? "," : " ";
}

} // namespace

namespace detail {

std::optional<double> numberIn(std::string_view word)
{
    double number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error == std::errc::result_out_of_range)
        return std::strtod(std::string(word).c_str(), nullptr); // 0 or infinite
    if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
    return number;
}

std::optional<std::int64_t> integerIn(std::string_view word)
{
    std::int64_t number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
    return number;
}

} // namespace detail

std::string Parameter::option() const
{
    if (!info.option.empty()) return std::string(info.option);
    std::string option = "--" + std::string(key);
    std::replace(option.begin(), option.end(), '_', '-');
    return option;
}

std::string Parameter::kind() const
{
    if (!choices.empty()) return fmt::format("one of {}", fmt::join(choices, ", "));
    if (type == WordType::kFlag) return "true or false";
    const bool isInteger = type == WordType::kInteger;
    std::string what = type == WordType::kText ? "text" : isInteger ? "a whole number" : "a number";
    if (most > 1) {
        const std::string count = isList() ? (type == WordType::kText ? "" : fmt::format("{} to {} ", least, most))
                                           : fmt::format("{} ", least);
        what = count + (type == WordType::kText ? "names" : isInteger ? "whole numbers" : "numbers");
    }
    const Limits& limits = info.limits;
    const bool hasLeast = std::isfinite(limits.least), hasMost = std::isfinite(limits.most);
    if (hasLeast && limits.isAbove) what += fmt::format(" above {}", limits.least);
    if (hasLeast && !limits.isAbove) what += fmt::format(" from {}", limits.least);
    if (hasMost) what += fmt::format(" {} {}", hasLeast && !limits.isAbove ? "to" : "up to", limits.most);
    return what;
}

void Parameter::check(const Words& words) const
{
    const auto refuse = [&] {
        throw ParameterError(
            fmt::format("`{}` cannot be {:.100}; it is {}", key, fmt::format("{}", fmt::join(words, " ")), kind()));
    };
    const bool fits =
        repeats ? !words.empty() && words.size() % least == 0 : words.size() >= least && words.size() <= most;
    if (!fits) refuse();
    for (const std::string& word : words) {
        if (type == WordType::kFlag && word != "true" && word != "false") refuse();
        if (!choices.empty() && std::find(choices.begin(), choices.end(), word) == choices.end()) refuse();
        if (type == WordType::kInteger && !detail::integerIn(word)) refuse();
        if (type == WordType::kFlag || type == WordType::kText) continue;
        const std::optional<double> number = detail::numberIn(word);
        const Limits& limits = info.limits;
        const bool isIn = number && *number <= limits.most && // false for NaN
                          (limits.isAbove ? *number > limits.least : *number >= limits.least);
        if (!isIn) refuse();
    }
}

std::string Parameter::value() const
{
    return fmt::format("{}", fmt::join(get(), separator(*this)));
}

Parameters joined(std::initializer_list<Parameters> lists)
{
    Parameters all;
    for (const Parameters& list : lists)
        all.insert(all.end(), list.begin(), list.end());
    return all;
}

const Parameter* find(const Parameters& parameters, std::string_view key)
{
    const auto found =
        std::find_if(parameters.begin(), parameters.end(), [&](const Parameter& p) { return p.key == key; });
    return found == parameters.end() ? nullptr : &*found;
}

void checkLimits(const Parameters& parameters)
{
    for (const Parameter& parameter : parameters) {
        if (const Words words = parameter.get(); !words.empty()) parameter.check(words);
    }
}

std::vector<std::string> planLines(const Parameters& defaults, const Parameters& said, const Parameters& plan,
                                   const std::function<std::string(const Parameter&)>& chooser)
{
    std::vector<std::string> lines;
    for (std::size_t i = 0; i < plan.size(); ++i) {
        const std::string value = plan[i].value(), byDefault = defaults[i].value();
        const bool isGiven = said[i].value() != byDefault;
        if (value.empty() || (!isGiven && value == byDefault)) continue;
        lines.push_back(fmt::format("plan: `{}` {} ({})", plan[i].key, value, isGiven ? "given" : chooser(plan[i])));
    }
    return lines;
}

void set(const Parameters& parameters, const std::map<std::string, Words>& given)
{
    for (const auto& [key, words] : given) {
        const Parameter* const known = find(parameters, key);
        if (!known) throw ParameterError(fmt::format("there is no parameter `{}`", key));
        known->check(words);
        if (given.contains(std::string(known->info.excludes))) {
            throw ParameterError(fmt::format("`{}` and `{}` exclude each other", key, known->info.excludes));
        }
    }
    for (const Parameter& parameter : parameters) {
        const auto words = given.find(std::string(parameter.key));
        if (words != given.end()) parameter.set(words->second);
    }
}

} // namespace vdblic
