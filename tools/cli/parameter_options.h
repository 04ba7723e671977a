#pragma once

#include "vdblic/core/parameters.h"

#include <CLI/CLI.hpp>

#include <map>
#include <string>

namespace vdblic::cli {

inline constexpr const char* kExpertGroup = "Expert"; ///< at the end of the help

/// The options of described parameters. Construct before parsing; this must outlive the parsing.
class ParameterOptions {
  public:
    /// Add an option for each parameter, those of experts in a group at the end.
    ParameterOptions(CLI::App& app, Parameters parameters);
    ParameterOptions(const ParameterOptions&) = delete;
    ParameterOptions& operator=(const ParameterOptions&) = delete;

    [[nodiscard]] const Parameters& parameters() const { return mParameters; }
    /// The values that the command line gives, by key.
    [[nodiscard]] const std::map<std::string, Words>& given() const { return mGiven; }
    /// Set the parameters that the command line gives. @throws ParameterError; InputError naming a file
    void apply() const { set(mParameters, mGiven); }

  private:
    void add(CLI::App& app, const Parameter& parameter);

    Parameters mParameters;
    std::map<std::string, Words> mGiven;
};

/// The parameters as JSON, for manuals, completions and documents: an array with an object for each, which has `key`,
/// `option`, `type`, `text` and, where there are any, `words`, `unit`, `default`, `choices`, `least`, `most`, `group`,
/// `required`, `repeats` and `expert`.
[[nodiscard]] std::string toJson(const Parameters& parameters);

} // namespace vdblic::cli
