#pragma once

#include "vdblic/core/parameters.h"

#include <pybind11/pybind11.h>

namespace vdblic::python {

/// Set parameters from keyword arguments. A value is a number, a text, true or false, or a sequence of those, nested
/// for what may be repeated. A sequence for a parameter of one text becomes the text of a command line: `a,b` of [a,
/// b], `0:x,1:y` of [(0, x), (1, y)].
/// @throws ParameterError on a keyword that no parameter has, or a value of another type or out of bounds
void setFrom(const pybind11::dict& keywords, const Parameters& parameters);

/// The parameters as dictionaries of `key`, `text`, `kind`, `unit` and `default`, for documentation.
[[nodiscard]] pybind11::list described(const Parameters& parameters);

} // namespace vdblic::python
