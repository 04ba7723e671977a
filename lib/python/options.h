#pragma once

#include "vdblic/core/parameters.h"

#include <pybind11/pybind11.h>

#include <string>
#include <string_view>

namespace vdblic::python {

/// The keyword argument that sets a parameter: the name of its option, with an underscore after Python's own words.
/// A positional argument keeps its key.
[[nodiscard]] std::string keywordOf(const Parameter& parameter);

/// A message of the library, with keywords in place of the keys of parameters in backticks.
[[nodiscard]] std::string withKeywords(std::string_view message);

/// Set parameters from keyword arguments. A value is a number, a text, true or false, a sequence of these, nested
/// for a repeatable parameter, or a duration for seconds. One number stands for two equal ones, and a whole number may
/// be a float. A sequence for a parameter of one text becomes the text of a command line: `a,b` of [a, b], `0:x,1:y` of
/// [(0, x), (1, y)].
/// @throws ParameterError on a keyword that no parameter has, or a value of another type or out of bounds
void setFrom(const pybind11::dict& keywords, const Parameters& parameters);

/// The parameters as dictionaries, for documentation: `key` (the keyword), `text`, `kind`, `unit`, `default`, `type`,
/// `choices`, and whether it holds `several` words.
[[nodiscard]] pybind11::list described(const Parameters& parameters);

} // namespace vdblic::python
