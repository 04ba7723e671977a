#include "cli/parameter_options.h"

#include "vdblic/core/nearest_name.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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

ParameterOptions::ParameterOptions(CLI::App& app, Parameters parameters, std::vector<OptionGroup> groups)
    : mParameters(std::move(parameters)), mGroups(std::move(groups))
{
    for (const Parameter& parameter : mParameters) {
        if (groupOf(parameter.key).empty()) add(app, parameter);
    }
    for (const OptionGroup& group : mGroups) {
        for (const std::string_view key : group.keys)
            add(app, *find(mParameters, key))->group(std::string(group.name));
    }
}

std::string_view ParameterOptions::groupOf(std::string_view key) const
{
    for (const auto& [name, keys] : mGroups) {
        if (std::find(keys.begin(), keys.end(), key) != keys.end()) return name;
    }
    return {};
}

CLI::Option* ParameterOptions::add(CLI::App& app, const Parameter& parameter)
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
    return option->required(parameter.info.isRequired);
}

std::string ParameterOptions::toJson() const
{
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const Parameter& parameter : mParameters) {
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
        const std::string_view group = groupOf(parameter.key);
        add("group", group);
        if (info.isRequired) entry["required"] = true;
        if (parameter.repeats) entry["repeats"] = true;
        if (group == kExpertGroup) entry["expert"] = true;
        list.push_back(std::move(entry));
    }
    return list.dump(2) + '\n';
}

void checkOptions(const CLI::App& app, int argc, char** argv)
{
    const std::vector<std::string> names = longNames(app);
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        if (argument == "--") return;
        if (!argument.starts_with("--") || std::isalpha(static_cast<unsigned char>(argument[2])) == 0) continue;
        const std::string option = argument.substr(0, argument.find('='));
        if (std::find(names.begin(), names.end(), option) != names.end()) continue;
        const std::optional<std::string> nearest = nearestName(option, names);
        throw CLI::ExtrasError(fmt::format("there is no option {:.60}{}", option,
                                           nearest ? fmt::format("; {} is one", *nearest) : std::string()),
                               CLI::ExitCodes::ExtrasError);
    }
}

} // namespace vdblic::cli
