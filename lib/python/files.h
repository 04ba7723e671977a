#pragma once

#include "vdblic/io/vdb_file.h"

#include <string>
#include <vector>

namespace vdblic::python {

/// The named grids of a file, or without names all of its grids of numbers and vectors.
/// @throws InputError if a named grid is missing or not of numbers, or the file has none
[[nodiscard]] openvdb::GridPtrVec chosenGrids(const VdbFile& file, const std::vector<std::string>& names);

} // namespace vdblic::python
