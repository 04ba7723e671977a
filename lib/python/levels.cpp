#include "bindings.h"

#include "files.h"
#include "text.h"
#include "vdblic/core/errors.h"
#include "vdblic/field/coarser.h"
#include "vdblic/io/texture_name.h"
#include "vdblic/io/vdb_file.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <type_traits>
#include <vector>

namespace vdblic::python {
namespace {

namespace py = pybind11;

/// Whether half precision represents the values of a float or vector grid well.
bool suitsHalf(const openvdb::GridBase& grid)
{
    constexpr float kLeastLargest = 1.0f / 16, kMost = 65504;
    float largest = 0;
    bool isFinite = true;
    const auto add = [&](float number) {
        largest = std::max(largest, std::abs(number));
        isFinite = isFinite && std::isfinite(number);
    };
    grid.apply<openvdb::TypeList<openvdb::FloatGrid, openvdb::Vec3SGrid>>([&](const auto& typed) {
        for (auto value = typed.cbeginValueOn(); value; ++value) {
            if constexpr (openvdb::VecTraits<typename std::decay_t<decltype(typed)>::ValueType>::IsVec) {
                for (int i = 0; i < 3; ++i)
                    add((*value)[i]);
            } else {
                add(*value);
            }
        }
    });
    return isFinite && (largest == 0 || (largest >= kLeastLargest && largest <= kMost));
}

/// Write the first coarser copies of a file's named grids, or without names of all its grids of numbers and vectors.
/// Each copy has half the voxels of the one before along each axis.
void writeLevels(const std::filesystem::path& source, const std::vector<std::filesystem::path>& paths,
                 const py::sequence& texts)
{
    const std::vector<std::string> names = fromTexts(texts);
    const py::gil_scoped_release release;
    VdbFile file = readVdb(source);
    openvdb::GridPtrVec grids = chosenGrids(file, names);
    file.grids.clear();
    const std::string sparse = isSparse(file.metadata) ? textureName(file.metadata, "") : "";
    std::int32_t level = 0;
    for (const std::filesystem::path& path : paths) {
        for (openvdb::GridBase::Ptr& grid : grids) {
            try {
                grid = coarser(*grid, !sparse.empty() && grid->getName() == sparse);
            } catch (const InputError& error) {
                throw InputError(fmt::format("{}: grid '{}': {}", source.string(), grid->getName(), error.what()));
            }
        }
        const bool half = std::all_of(grids.begin(), grids.end(), [](const auto& grid) { return suitsHalf(*grid); });
        for (const openvdb::GridBase::Ptr& grid : grids)
            grid->setSaveFloatAsHalf(half);
        file.metadata.removeMeta("level");
        file.metadata.insertMeta("level", openvdb::Int32Metadata(++level));
        writeVdb(path, {grids.begin(), grids.end()}, file.metadata);
    }
}

} // namespace

void bindLevels(py::module_& module)
{
    module.def("write_levels", &writeLevels);
}

} // namespace vdblic::python
