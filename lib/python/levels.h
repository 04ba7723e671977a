#pragma once

#include <pybind11/pybind11.h>

namespace vdblic::python {

/// Add `write_levels`, which makes coarser copies of a file.
void bindLevels(pybind11::module_& module);

} // namespace vdblic::python
