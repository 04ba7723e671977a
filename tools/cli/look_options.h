#pragma once

#include "cli/tool.h"
#include "vdblic/render/render_sequence.h"

#include <functional>

namespace vdblic::cli {

/// The options of how a picture looks and what is cut away, on top of a look with a name.
///
/// Add them before parsing; they and the parameters must outlive it.
class LookOptions {
  public:
    LookOptions(Tool& tool, RenderParams& params);

    /// Set look, cuts and background as they were asked for.
    /// @throws ParameterError, InputError naming a transfer function's file
    void apply() const;

  private:
    /// An option whose value is used once the look is set.
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
