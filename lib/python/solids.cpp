#include "bindings.h"

#include "vdblic/cast/solid.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/render/loaded_texture.h"
#include "vdblic/render/render_plan.h"

#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <openvdb/openvdb.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <pybind11/numpy.h>
#include <pybind11/stl/filesystem.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace vdblic::python {
namespace {

namespace py = pybind11;

/// The triangles of a surface; OpenVDB's mesher makes quads of most.
std::vector<openvdb::Vec3I> trianglesOf(std::vector<openvdb::Vec3I> triangles, const std::vector<openvdb::Vec4I>& quads)
{
    for (const openvdb::Vec4I& quad : quads) {
        triangles.emplace_back(quad[0], quad[1], quad[2]);
        triangles.emplace_back(quad[0], quad[2], quad[3]);
    }
    return triangles;
}

py::tuple solidMesh(const std::string& source, const std::filesystem::path& lines, std::int64_t frame)
{
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    glm::dmat4 toWorld;
    {
        const py::gil_scoped_release release;
        const PicturePlan plan = resolve(PictureParams{}, {.isSparse = true});
        const LoadedTexture loaded = loadFrame(plan, {frame, lines});
        const Solid solid = makeSolid(source, *loaded.domain(), glm::dvec3(1), frame);
        std::vector<openvdb::Vec4I> quads;
        openvdb::tools::volumeToMesh(*solid.levelSet, points, triangles, quads, 0.0, 0.0);
        triangles = trianglesOf(std::move(triangles), quads);
        toWorld = glm::inverse(solid.worldToIndex);
    }
    py::array_t<double> places({py::ssize_t(points.size()), py::ssize_t(3)});
    py::array_t<std::uint32_t> corners({py::ssize_t(triangles.size()), py::ssize_t(3)});
    auto place = places.mutable_unchecked<2>();
    auto corner = corners.mutable_unchecked<2>();
    for (std::size_t i = 0; i < points.size(); ++i) {
        const glm::dvec4 world = toWorld * glm::dvec4(points[i][0], points[i][1], points[i][2], 1);
        for (int axis = 0; axis < 3; ++axis)
            place(py::ssize_t(i), axis) = world[axis];
    }
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        for (int c = 0; c < 3; ++c)
            corner(py::ssize_t(i), c) = triangles[i][c];
    }
    return py::make_tuple(places, corners, solidChanges(source));
}

} // namespace

void bindSolids(py::module_& module)
{
    module.def("solid_mesh", &solidMesh);
}

} // namespace vdblic::python
