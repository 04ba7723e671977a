#include "cli/parameter_options.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

namespace vdblic::cli {
namespace {

/// The text of the help: what the parameter does, its unit, its choices and bounds.
std::string helpOf(const Parameter& parameter)
{
    std::string help(parameter.text);
    const auto [least, most, isAbove] = parameter.info.limits;
    constexpr double kFew = 1e7, kTiny = 1e-7; // wider bounds protect the machine, and are not shown
    const bool isBounded =
        (std::isfinite(least) || std::isfinite(most)) && !(std::abs(most) > kFew && least < kTiny && least != 0);
    const bool isSpecial = !parameter.choices.empty() || (isBounded && !(most > kFew && std::isfinite(most)));
    const std::string unit = parameter.info.unit.empty() ? "" : fmt::format(" [{}]", parameter.info.unit);
    if (isSpecial && parameter.type != WordType::kFlag) {
        std::string kind = parameter.kind();
        kind.front() = char(std::toupper(static_cast<unsigned char>(kind.front())));
        return fmt::format("{} {}{}.", help, kind, unit);
    }
    if (!unit.empty() && help.ends_with('.')) return help.substr(0, help.size() - 1) + unit + '.';
    return help;
}

std::string typeOf(const Parameter& parameter)
{
    constexpr std::array<const char*, 4> kNamesOfTypes = {"flag", "integer", "number", "text"};
    return parameter.choices.empty() ? kNamesOfTypes[std::size_t(parameter.type)] : "choice";
}

} // namespace

ParameterOptions::ParameterOptions(CLI::App& app, Parameters parameters) : mParameters(std::move(parameters))
{
    for (const bool isExpert : {false, true}) {
        for (const Parameter& parameter : mParameters) {
            if (parameter.info.isExpert == isExpert) add(app, parameter);
        }
    }
}

void ParameterOptions::add(CLI::App& app, const Parameter& parameter)
{
    const std::string key(parameter.key);
    const auto keep = [this, key](const CLI::results_t& words) {
        mGiven[key] = words;
        return true;
    };
    CLI::Option* option = nullptr;
    if (parameter.type == WordType::kFlag) {
        option = app.add_flag_function(
            parameter.option(), [this, key](std::int64_t count) { mGiven[key] = {count > 0 ? "true" : "false"}; },
            helpOf(parameter));
    } else {
        option = app.add_option(parameter.option(), keep, helpOf(parameter));
        const int words = int(parameter.least);
        constexpr int kMany = 1 << 28;
        option->type_size(words)->expected(1, parameter.isList() || parameter.repeats ? kMany : 1);
        const bool isCut = parameter.isList() || (words > 3 && !parameter.repeats);
        if (isCut) option->delimiter(',');
        option->allow_extra_args(false);
        if (!parameter.info.words.empty()) {
            option->type_name(std::string(parameter.info.words));
        } else {
            option->type_name(parameter.type == WordType::kInteger  ? "INT"
                              : parameter.type == WordType::kNumber ? "FLOAT"
                                                                    : "TEXT");
        }
        if (parameter.isPositional()) option->type_name("");
        const std::string text = parameter.value();
        if (!text.empty()) option->default_str(text);
    }
    option->required(parameter.info.isRequired);
    if (parameter.info.isExpert) {
        option->group(kExpertGroup);
    } else if (!parameter.info.group.empty() && !parameter.isPositional()) {
        option->group(std::string(parameter.info.group));
    }
}

std::string toJson(const Parameters& parameters)
{
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const Parameter& parameter : parameters) {
        const ParameterInfo& info = parameter.info;
        nlohmann::ordered_json entry = {{"key", parameter.key},
                                        {"option", parameter.option()},
                                        {"type", typeOf(parameter)},
                                        {"text", parameter.text}};
        const auto add = [&](const char* name, std::string_view text) {
            if (!text.empty()) entry[name] = text;
        };
        add("words", info.words);
        add("unit", info.unit);
        add("default", parameter.type == WordType::kFlag ? "" : parameter.value());
        if (!parameter.choices.empty()) entry["choices"] = parameter.choices;
        if (std::isfinite(info.limits.least)) entry[info.limits.isAbove ? "above" : "least"] = info.limits.least;
        if (std::isfinite(info.limits.most)) entry["most"] = info.limits.most;
        add("group", info.group);
        if (info.isRequired) entry["required"] = true;
        if (parameter.repeats) entry["repeats"] = true;
        if (info.isExpert) entry["expert"] = true;
        list.push_back(std::move(entry));
    }
    return list.dump(2) + '\n';
}

} // namespace vdblic::cli
