#include "bindings.h"

#include "vdblic/camera/camera_path.h"

#include <glm/vec3.hpp>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <optional>

namespace vdblic::python {
namespace {

namespace py = pybind11;

py::dict cameraAt(const CameraKeys& keys, double frame)
{
    const CameraParams params = keys.applied({}, frame);
    py::dict result;
    const auto set = [&](const char* name, const std::optional<glm::dvec3>& point) {
        if (point) result[name] = py::make_tuple(point->x, point->y, point->z);
    };
    set("eye", params.eye);
    set("target", params.target);
    set("up", params.up);
    if (!keys.fieldOfView.empty()) result["fov"] = params.fieldOfView;
    if (params.viewHeight) result["height"] = *params.viewHeight;
    return result;
}

} // namespace

void bindCameraFile(py::module_& module)
{
    py::class_<CameraKeys>(module, "CameraFile")
        .def(py::init([](const std::filesystem::path& path) { return readCameraKeys(path); }))
        .def("at", &cameraAt);
}

} // namespace vdblic::python
