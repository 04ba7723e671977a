#pragma once

#include "vdblic/io/vdb_file.h"

#include <openvdb/openvdb.h>
#include <pybind11/pybind11.h>

namespace vdblic::python {

/// A grid of floats, doubles or vectors of them as a dictionary: `name`, `values` (x, y, z[, 3]) and `active` (x, y, z)
/// over the box of its active voxels, `origin` (index of the first value), `transform` (4 × 4, on columns),
/// `staggered`, `metadata`. None for a grid of another type.
/// @throws InputError if the box does not fit in memory
[[nodiscard]] pybind11::object toDictionary(const openvdb::GridBase& grid);

/// The grid of such a dictionary. Arrays of single precision in C order are read where they are.
/// @throws ParameterError naming what is wrong
[[nodiscard]] openvdb::GridBase::Ptr toGrid(const pybind11::dict& dictionary);

[[nodiscard]] openvdb::GridPtrVec toGrids(const pybind11::list& dictionaries); ///< as toGrid()

[[nodiscard]] pybind11::dict toDictionary(const openvdb::MetaMap& metadata);
[[nodiscard]] openvdb::MetaMap toMetadata(const pybind11::dict& dictionary);

} // namespace vdblic::python
