#pragma once

#include "vdblic/io/vdb_file.h"

#include <openvdb/openvdb.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <optional>
#include <string>

namespace vdblic::python {

/// Whether a grid holds floats, doubles or vectors of them, on a linear transform.
[[nodiscard]] bool isOfNumbers(const openvdb::GridBase& grid);
/// Whether toDictionary() accepts a grid: floats, doubles, vectors or 32-bit integers on a linear transform.
[[nodiscard]] bool hasArrays(const openvdb::GridBase& grid);

/// A value as an array. Nothing if it is none.
[[nodiscard]] std::optional<pybind11::array> asArray(const pybind11::handle& value);

/// A linear transform as a matrix, 4 × 4, on columns.
[[nodiscard]] pybind11::object matrixOf(const openvdb::math::Transform& transform);

/// A grid of numbers as a dictionary: `name`, `values` (x, y, z[, 3]) and `active` (x, y, z) over a box, `origin`
/// (index of the first value), `transform` (4 × 4, on columns), `staggered`, `metadata`.
/// @param box by default the box of the active voxels
/// @throws InputError if the box does not fit in memory
[[nodiscard]] pybind11::dict toDictionary(const openvdb::GridBase& grid,
                                          const std::optional<openvdb::CoordBBox>& box = {});

/// The grid of such a dictionary. Arrays of single precision in C order are not copied.
/// @throws ParameterError naming the grid and the error
[[nodiscard]] openvdb::GridBase::Ptr toGrid(const pybind11::dict& dictionary);

/// A handle of Python on a volume's streaks: holds the grid, from which their arrays are read.
struct __attribute__((visibility("hidden"))) StoredLines {
    openvdb::GridBase::Ptr grid;
};
[[nodiscard]] bool isOfLines(const openvdb::GridBase& grid);

/// Grids for Python: dictionaries, and StoredLines. Grids of other types are skipped.
[[nodiscard]] pybind11::list toList(openvdb::GridPtrVec grids);

/// A volume of such a list. @param name in messages; may be empty
/// @throws ParameterError naming the volume, the grid and the error
[[nodiscard]] VdbFile toVolume(const pybind11::list& grids, const pybind11::dict& metadata, const std::string& name);

} // namespace vdblic::python
