#pragma once

#include "vdblic/io/vdb_file.h"

#include <pybind11/pybind11.h>

#include <string>
#include <vector>

namespace vdblic::python {

/// The grids of numbers and vectors among some of a file, or among all.
/// @throws InputError if one of them is missing, or there is none
[[nodiscard]] openvdb::GridPtrVec chosenGrids(const VdbFile& file, const std::vector<std::string>& names);

/// Add what vdblic_convert (tools/python) takes from the library: the errors, frame patterns and lists, paths on
/// standard input, checks of outputs, files that appear whole, and the grids of a file over one box.
void bindFiles(pybind11::module_& module);

} // namespace vdblic::python
