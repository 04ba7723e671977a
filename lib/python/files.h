#pragma once

#include <pybind11/pybind11.h>

namespace vdblic::python {

/// Add what vdblic_convert (tools/python) takes from the library: the errors, frame patterns and lists, paths on
/// standard input, checks of outputs, files that appear whole, and the grids of a file over one box.
void bindFiles(pybind11::module_& module);

} // namespace vdblic::python
