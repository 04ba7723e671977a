#pragma once

#include <pybind11/pybind11.h>

namespace vdblic::python {

/// Add what vdblic_convert (tools/python) uses of the library: the errors, frame patterns and lists, paths on standard
/// input, checks of outputs, files that appear whole, and the grids of a file over one box.
void bindFiles(pybind11::module_& module);

/// Add `read_headers(path)`: the grids of a file without their voxels, and the file's metadata.
///
/// A grid is a dictionary: `name`, `type` (float, vec3s ...), `class` (fog volume ...), `numbers` (whether it is of
/// floats, doubles or vectors of them on a linear transform), and, on a linear transform, `transform` (4 × 4, on
/// columns) and `box` (first and last index of the active voxels, None if there are none). Only files of the few
/// writers that store no boxes are read whole.
void bindGridHeaders(pybind11::module_& module);

/// Add `write_levels`, which makes coarser copies of a file.
void bindLevels(pybind11::module_& module);

/// Add `LINES`, the name of the grid of streaks as lines, and `read_lines(path)`: its lines, and the file's metadata.
///
/// The lines, as `arrays()` of StoredLines gives them too, are a dictionary of arrays: for each line `id`, `counts` (of
/// its points) and `source`; for each point `points` (world space), `radius` (world units), `opacity`, `age` (frames)
/// and `scalars` by name. `colors_of(name, positions)` looks positions on a colour map up, in linear light.
void bindLines(pybind11::module_& module);

/// Add `solid_mesh(source, lines, frame)`: the surface of a solid as vdblic_render has it, of a frame's file of lines.
///
/// Points (n, 3) in world space, triangles (m, 3) of their numbers, and whether each frame has a solid of its own.
void bindSolids(pybind11::module_& module);

} // namespace vdblic::python
