#pragma once

#include "vdblic/core/errors.h"

#include <fmt/format.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <functional>
#include <string>

namespace vdblic::python {

/// Keyword arguments that were given, by name. @throws ParameterError if one has a value of another type
class __attribute__((visibility("hidden"))) Options { // as what it holds
  public:
    explicit Options(pybind11::dict given) : mGiven(std::move(given)) {}

    [[nodiscard]] bool has(const char* name) const { return mGiven.contains(name); }

    template<typename T>
    [[nodiscard]] T get(const char* name) const
    {
        try {
            return mGiven[name].template cast<T>();
        } catch (const pybind11::cast_error&) {
            throw ParameterError(fmt::format("`{}` cannot be {}", name,
                                             pybind11::repr(mGiven[name]).template cast<std::string>().substr(0, 100)));
        }
    }

    /// Set a parameter if its argument was given.
    template<typename T>
    void set(const char* name, T& target) const
    {
        if (has(name)) target = get<T>(name);
    }

    /// Set a parameter from a text if its argument was given.
    template<typename T>
    void parse(const char* name, T& target, const std::function<T(std::string)>& parse) const
    {
        if (has(name)) target = parse(get<std::string>(name));
    }

  private:
    pybind11::dict mGiven;
};

} // namespace vdblic::python
