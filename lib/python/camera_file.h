#pragma once

#include <pybind11/pybind11.h>

namespace vdblic::python {

/// Add `CameraFile(path)`, the key frames of a camera (docs/formats.md), whose `at(frame)` is a dictionary of
/// those that the file sets among `eye`, `target`, `up`, `fov` (vertical, degrees) and `height`.
void bindCameraFile(pybind11::module_& module);

} // namespace vdblic::python
