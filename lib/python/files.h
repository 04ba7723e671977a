#pragma once

#include "vdblic/io/vdb_file.h"

#include <string>
#include <vector>

namespace vdblic::python {

/// The grids of numbers and vectors among some of a file, or among all.
/// @throws InputError if one of them is missing, or there is none
[[nodiscard]] openvdb::GridPtrVec chosenGrids(const VdbFile& file, const std::vector<std::string>& names);

} // namespace vdblic::python
