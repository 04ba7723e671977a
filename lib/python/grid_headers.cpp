#include "bindings.h"

#include "grid_arrays.h"
#include "metadata.h"
#include "text.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/io/vdb_header.h"

#include <openvdb/openvdb.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <filesystem>
#include <utility>

namespace vdblic::python {
namespace {

namespace py = pybind11;

/// The header of a file whose grids know their boxes.
VdbHeader headerWithBoxes(const std::filesystem::path& path)
{
    VdbHeader header = readVdbHeader(path);
    const auto hasBox = [](const auto& grid) { return storedBox(*grid).has_value(); };
    if (!header.grids.empty() && std::all_of(header.grids.begin(), header.grids.end(), hasBox)) return header;
    VdbFile file = readVdb(path);
    for (const openvdb::GridBase::Ptr& grid : file.grids)
        grid->addStatsMetadata();
    return {file.metadata, std::move(file.grids)};
}

py::object indexOf(const openvdb::Coord& voxel)
{
    return py::make_tuple(voxel.x(), voxel.y(), voxel.z());
}

py::dict describe(const openvdb::GridBase& grid)
{
    py::dict result;
    result["name"] = toText(grid.getName());
    result["type"] = grid.valueType();
    result["class"] = openvdb::GridBase::gridClassToString(grid.getGridClass());
    result["numbers"] = isOfNumbers(grid);
    if (!grid.transform().isLinear()) return result;
    result["transform"] = matrixOf(grid.transform());
    const openvdb::CoordBBox box = storedBox(grid).value_or(openvdb::CoordBBox());
    result["box"] = box.empty() ? py::object(py::none()) : py::make_tuple(indexOf(box.min()), indexOf(box.max()));
    return result;
}

py::tuple readHeaders(const std::filesystem::path& path)
{
    VdbHeader header;
    {
        const py::gil_scoped_release release;
        header = headerWithBoxes(path);
    }
    py::list grids;
    for (const openvdb::GridBase::Ptr& grid : header.grids)
        grids.append(describe(*grid));
    return py::make_tuple(grids, toDictionary(header.metadata));
}

} // namespace

void bindGridHeaders(py::module_& module)
{
    module.def("read_headers", &readHeaders);
}

} // namespace vdblic::python
