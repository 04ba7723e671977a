#pragma once

#include "vdblic/core/parameters.h"

#include <CLI/CLI.hpp>

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic::cli {

inline constexpr const char* kExpertGroup = "Expert"; ///< at the end of the help

/// A group of the help, and the keys of its parameters, in order.
struct OptionGroup {
    std::string_view name;
    std::vector<std::string_view> keys;
};

/// The options of described parameters. Construct before parsing; this must outlive the parsing.
class ParameterOptions {
  public:
    /// Add an option for each parameter: first without a group, then by groups.
    ParameterOptions(CLI::App& app, Parameters parameters, std::vector<OptionGroup> groups = {});
    ParameterOptions(const ParameterOptions&) = delete;
    ParameterOptions& operator=(const ParameterOptions&) = delete;

    [[nodiscard]] const Parameters& parameters() const { return mParameters; }
    /// The parameters as JSON, for manuals, completions and documents: an array with an object for each, which has
    /// `key`, `option`, `type`, `text` and, where there are any, `words`, `unit`, `default`, `choices`, `least`,
    /// `most`, `group`, `required`, `repeats` and `expert`.
    [[nodiscard]] std::string toJson() const;
    /// The values that the command line gives, by key.
    [[nodiscard]] const std::map<std::string, Words>& given() const { return mGiven; }
    /// Set the parameters that the command line gives. @throws ParameterError; InputError naming a file
    void apply() const { set(mParameters, mGiven); }

  private:
    CLI::Option* add(CLI::App& app, const Parameter& parameter);
    [[nodiscard]] std::string_view groupOf(std::string_view key) const; // empty: none

    Parameters mParameters;
    std::vector<OptionGroup> mGroups;
    std::map<std::string, Words> mGiven;
};

/// Check that every argument that looks like an option is one, before the parser reports missing options.
/// @throws CLI::ExtrasError naming the first one that is not, and the nearest option
void checkOptions(const CLI::App& app, int argc, char** argv);

} // namespace vdblic::cli
