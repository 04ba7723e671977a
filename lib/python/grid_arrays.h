#pragma once

#include "vdblic/io/vdb_file.h"

#include <openvdb/openvdb.h>
#include <pybind11/pybind11.h>

#include <optional>

namespace vdblic::python {

/// Whether a grid holds floats, doubles or vectors of them, on a linear transform.
[[nodiscard]] bool isOfNumbers(const openvdb::GridBase& grid);

/// A linear transform as a matrix, 4 × 4, on columns.
[[nodiscard]] pybind11::object matrixOf(const openvdb::math::Transform& transform);

/// A grid of numbers as a dictionary: `name`, `values` (x, y, z[, 3]) and `active` (x, y, z) over a box, `origin`
/// (index of the first value), `transform` (4 × 4, on columns), `staggered`, `metadata`.
/// @param box that of its active voxels unless given
/// @throws InputError if the box does not fit in memory
[[nodiscard]] pybind11::dict toDictionary(const openvdb::GridBase& grid,
                                          const std::optional<openvdb::CoordBBox>& box = {});

/// The grid of such a dictionary. Arrays of single precision in C order are read where they are.
/// @throws ParameterError naming what is wrong
[[nodiscard]] openvdb::GridBase::Ptr toGrid(const pybind11::dict& dictionary);

[[nodiscard]] openvdb::GridPtrVec toGrids(const pybind11::list& dictionaries); ///< as toGrid()

[[nodiscard]] pybind11::dict toDictionary(const openvdb::MetaMap& metadata);
[[nodiscard]] openvdb::MetaMap toMetadata(const pybind11::dict& dictionary);

} // namespace vdblic::python
