#pragma once

#include <pybind11/pybind11.h>

namespace vdblic::python {

/// Add `read_headers(path)`: what a file tells of its grids without their voxels, as (list of grids, file metadata).
///
/// A grid is a dictionary: `name`, `type` (float, vec3s ...), `class` (fog volume ...), `numbers` (whether it is of
/// floats, doubles or vectors of them on a linear transform), and, on a linear transform, `transform` (4 × 4, on
/// columns) and `box` (first and last index of the active voxels, None if there are none). Only files of the few
/// writers that store no boxes are read whole.
void bindGridHeaders(pybind11::module_& module);

} // namespace vdblic::python
