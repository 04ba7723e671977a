#pragma once

#include "vdblic/render/render_params.h"

#include <CLI/CLI.hpp>

#include <functional>
#include <string>
#include <vector>

namespace vdblic::cli {

/// The options for the look of a picture and for cuts, on top of a named look.
///
/// Construct before parsing. This and the parameters must outlive the parsing.
class LookOptions {
  public:
    LookOptions(CLI::App& app, RenderParams& params);

    /// Set look, cuts and background in the parameters.
    /// @throws ParameterError; InputError naming the file of a transfer function
    void apply() const;

  private:
    /// An option whose value is applied on top of the look.
    template<typename Value>
    CLI::Option* option(const std::string& name, const std::string& help, std::function<void(const Value&)> change)
    {
        const auto keep = [this, change](const Value& value) {
            mChanges.push_back([change, value] { change(value); });
        };
        return mApp.add_option_function<Value>(name, keep, help);
    }
    template<typename Number>
    void number(const std::string& name, Number& target, const std::string& help)
    {
        option<Number>(name, help, [&target](Number value) { target = value; });
    }

    CLI::App& mApp;
    RenderParams& mParams;
    std::string mLook = "flow";
    std::vector<std::function<void()>> mChanges; // in the order in which the options were added
};

} // namespace vdblic::cli
