#include "bindings.h"

#include "grid_arrays.h"
#include "metadata.h"
#include "text.h"
#include "vdblic/core/errors.h"
#include "vdblic/image/color_map.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/lines/line_grid.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <pybind11/numpy.h>
#include <pybind11/stl/filesystem.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace vdblic::python {
namespace {

namespace py = pybind11;

template<typename T>
py::array_t<T> arrayOf(const std::vector<T>& values)
{
    return py::array_t<T>(py::ssize_t(values.size()), values.data());
}

/// The points in world space (points, 3).
py::array_t<double> worldPositions(const Lines& lines, const openvdb::math::Transform& transform)
{
    py::array_t<double> positions({py::ssize_t(lines.pointCount()), py::ssize_t(3)});
    auto rows = positions.mutable_unchecked<2>();
    for (std::size_t i = 0; i < lines.pointCount(); ++i) {
        const openvdb::Vec3d place = transform.indexToWorld(openvdb::Vec3d(lines.positions[i]));
        for (int axis = 0; axis < 3; ++axis)
            rows(py::ssize_t(i), axis) = place[axis];
    }
    return positions;
}

py::dict lineArrays(const Lines& lines, const openvdb::math::Transform& transform)
{
    std::vector<std::int32_t> ids, counts, sources;
    for (const Lines::Line& line : lines.lines) {
        ids.push_back(line.id);
        counts.push_back(std::int32_t(line.end - line.begin));
        sources.push_back(line.source);
    }
    py::dict result, scalars;
    result["id"] = arrayOf(ids);
    result["counts"] = arrayOf(counts);
    result["source"] = arrayOf(sources);
    result["points"] = worldPositions(lines, transform);
    result["radius"] = arrayOf(lines.radii);
    result["opacity"] = arrayOf(lines.opacities);
    result["age"] = arrayOf(lines.ages);
    for (const Lines::Scalar& scalar : lines.scalars)
        scalars[toText(scalar.name)] = arrayOf(scalar.values);
    result["scalars"] = scalars;
    return result;
}

py::dict arraysOf(const StoredLines& stored)
{
    try {
        return lineArrays(linesOf(*stored.grid), stored.grid->transform());
    } catch (const InputError& error) {
        throw InputError(fmt::format("grid '{}': {}", kLineGrid, error.what()));
    }
}

py::tuple readLines(const std::filesystem::path& path)
{
    VdbFile file;
    openvdb::GridBase::Ptr grid;
    Lines lines;
    {
        const py::gil_scoped_release release;
        file = readVdb(path);
        grid = file.get<openvdb::GridBase>(kLineGrid);
        try {
            lines = linesOf(*grid);
        } catch (const InputError& error) {
            throw InputError(fmt::format("{}: grid '{}': {}", path.string(), kLineGrid, error.what()));
        }
    }
    return py::make_tuple(lineArrays(lines, grid->transform()), toDictionary(file.metadata));
}

/// Colours in linear light of positions on a colour map.
py::array_t<float> colorsOf(const std::string& name, const py::array_t<float>& positions)
{
    const std::vector<ColorPoint> points = colorMapPoints(name);
    const auto values = positions.unchecked<1>();
    py::array_t<float> colors({values.shape(0), py::ssize_t(3)});
    auto rows = colors.mutable_unchecked<2>();
    for (py::ssize_t i = 0; i < values.shape(0); ++i) {
        const glm::dvec3 color = linearFromDisplay(colorAt(points, double(values(i))));
        for (int channel = 0; channel < 3; ++channel)
            rows(i, channel) = float(color[channel]);
    }
    return colors;
}

} // namespace

void bindLines(py::module_& module)
{
    py::class_<StoredLines>(module, "StoredLines").def("arrays", &arraysOf);
    module.attr("LINES") = kLineGrid;
    module.def("read_lines", &readLines);
    module.def("colors_of", &colorsOf);
}

} // namespace vdblic::python
