#include "files.h"

#include "bindings.h"
#include "grid_arrays.h"
#include "metadata.h"
#include "options.h"
#include "text.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/extent.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/printable.h"
#include "vdblic/io/affine_rows.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/frame_list.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/io/output_pattern.h"
#include "vdblic/io/path_list.h"
#include "vdblic/io/sequence.h"
#include "vdblic/io/vdb_file.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <istream>
#include <memory>
#include <new>
#include <optional>
#include <streambuf>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

namespace vdblic::python {
namespace {

namespace py = pybind11;

/// Standard input. Before and after waiting for it, Python's handlers of signals run and then `check`, which may raise.
class CheckedBuffer : public std::streambuf {
  public:
    explicit CheckedBuffer(py::function check) : mCheck(std::move(check)) {}

  protected:
    int_type underflow() override
    {
        ssize_t count = 0;
        bool interrupted = false;
        do {
            if (PyErr_CheckSignals() != 0) throw py::error_already_set();
            mCheck();
            const py::gil_scoped_release release;
            count = ::read(STDIN_FILENO, mBytes.data(), mBytes.size());
            interrupted = count < 0 && errno == EINTR;
        } while (interrupted);
        if (count <= 0) return traits_type::eof();
        setg(mBytes.data(), mBytes.data(), mBytes.data() + count);
        return traits_type::to_int_type(*gptr());
    }

  private:
    py::function mCheck;
    std::array<char, 4096> mBytes;
};

class CheckedInput : public std::istream {
  public:
    explicit CheckedInput(py::function check) : std::istream(nullptr), mBuffer(std::move(check))
    {
        rdbuf(&mBuffer);
        exceptions(badbit); // the stream rethrows the buffer's exceptions
    }

  private:
    CheckedBuffer mBuffer;
};

/// The paths on standard input, one by one.
class InputPaths {
  public:
    explicit InputPaths(py::function check) : mInput(std::move(check)) {}

    std::filesystem::path next()
    {
        const std::optional<std::string> path = mPaths.next();
        if (!path) throw py::stop_iteration();
        return *path;
    }

  private:
    CheckedInput mInput;
    PathList mPaths{mInput};
};

/// The files of a sequence, one by one, as (frame, path).
class Sequence {
  public:
    Sequence(const SequenceParams& params, py::function check)
        : mInput(std::move(check)), mNext(openSequence(params, mInput, mCount))
    {
    }

    std::pair<std::int64_t, std::filesystem::path> next()
    {
        const std::optional<FrameFile> file = mNext();
        if (!file) throw py::stop_iteration();
        return {file->frame, file->path};
    }

  private:
    CheckedInput mInput;
    std::size_t mCount = 0;
    FrameSource mNext;
};

std::vector<std::pair<std::int64_t, std::filesystem::path>> filesOf(const SequenceParams& params)
{
    std::vector<std::pair<std::int64_t, std::filesystem::path>> files;
    for (const FrameFile& file : selectFrames(params))
        files.emplace_back(file.frame, file.path);
    return files;
}

/// The metadata of a file, completed by its grids' metadata.
py::dict metadataOf(const VdbFile& file)
{
    openvdb::MetaMap found;
    const auto replace = [&](const openvdb::MetaMap& by) {
        for (auto entry = by.beginMeta(); entry != by.endMeta(); ++entry) {
            found.removeMeta(entry->first); // OpenVDB throws where the types differ
            found.insertMeta(entry->first, *entry->second);
        }
    };
    for (std::size_t i = file.grids.size(); i > 0; --i)
        replace(*file.grids[i - 1]);
    replace(file.metadata);
    return toDictionary(found);
}

py::dict readMetadata(const std::filesystem::path& path)
{
    VdbFile file;
    {
        const py::gil_scoped_release release;
        const auto noLeaf = [](const openvdb::GridBase&, const openvdb::Coord&) { return false; };
        file = readVdb(path, noLeaf, false);
    }
    return metadataOf(file);
}

bool areAlike(const openvdb::math::Transform& a, const openvdb::math::Transform& b)
{
    constexpr double kNear = 1e-12; // relative
    const openvdb::Mat4d one = affineRows(a), other = affineRows(b);
    return std::equal(one.asPointer(), one.asPointer() + 16, other.asPointer(),
                      [](double x, double y) { return std::abs(x - y) <= kNear * std::max(std::abs(x), std::abs(y)); });
}

/// Check that memory can hold grids as dense arrays together with the output made from them.
/// @param box of the first grid, which the arrays of all cover
void checkDense(const std::string& path, const openvdb::GridPtrVec& grids, const openvdb::CoordBBox& box)
{
    constexpr double kVoxel = 10, kNumber = 8; // bytes, and bytes of a number: at least so many, as measured
    double bytes = kVoxel;
    for (const openvdb::GridBase::Ptr& grid : grids)
        bytes += kNumber * (grid->valueType().starts_with("vec3") ? 3 : 1);
    const double voxels = voxelsOf(box);
    const double active = 100 * double(grids.front()->activeVoxelCount()) / voxels;
    const std::string others = grids.size() == 1 ? "" : fmt::format(" and {} others", grids.size() - 1);
    checkMemory(bytes * voxels,
                fmt::format("{}: grid '{}'{}: the bounding box ({:.3g} million voxels, {:.2g} % of them active)", path,
                            grids.front()->getName(), others, voxels / 1e6, active),
                grids.size() == 1 ? "cut the grid" : "choose fewer with `grids`, or cut them");
}

/// Grids over the box around the active voxels of one of them, which comes first: that of the file's texture or the
/// first one. Each is a dictionary (grid_arrays.h) that also tells whether its voxels are `alike`; a grid of other
/// voxels has its own box. Of a staggered velocity the box has the faces above its last voxels too.
/// @return the grids and metadataOf() their file
py::tuple readOverOneBox(const std::filesystem::path& path, const py::sequence& texts)
{
    const std::vector<std::string> names = fromTexts(texts);
    VdbFile file;
    openvdb::GridPtrVec grids;
    {
        const py::gil_scoped_release release;
        file = readVdb(path);
        grids = chosenGrids(file, names);
    }
    const auto texture = file.metadata.getMetadata<openvdb::StringMetadata>("texture");
    const auto isTexture = [&](const auto& grid) { return texture && grid->getName() == texture->value(); };
    std::stable_partition(grids.begin(), grids.end(), isTexture);
    openvdb::CoordBBox box = grids.front()->evalActiveVoxelBoundingBox();
    if (box.empty()) box = openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(0));
    checkDense(path.string(), grids, box);
    const py::dict metadata = metadataOf(file);
    file.grids.clear();
    py::list dictionaries;
    for (openvdb::GridBase::Ptr& grid : grids) {
        const bool alike = areAlike(grid->transform(), grids.front()->transform());
        openvdb::CoordBBox own = alike ? box : grid->evalActiveVoxelBoundingBox();
        if (grid->getGridClass() == openvdb::GRID_STAGGERED) own.max().offset(1);
        try {
            dictionaries.append(toDictionary(*grid, own));
        } catch (const InputError& error) {
            throw InputError(fmt::format("{}: {}", path.string(), error.what()));
        }
        dictionaries[dictionaries.size() - 1]["alike"] = alike;
        if (grid != grids.front()) grid.reset();
    }
    return py::make_tuple(dictionaries, metadata);
}

/// Size, first index and transform of the box around the active voxels of a grid `FILE` or `FILE:GRID`.
py::dict readBox(const std::filesystem::path& reference)
{
    const GridReference parts = parseGridReference(reference.string());
    const py::gil_scoped_release release;
    const VdbFile file = readVdb(parts.path);
    const auto grid =
        parts.grid.empty() && !file.grids.empty() ? file.grids.front() : file.get<openvdb::GridBase>(parts.grid);
    const std::string where = fmt::format("{}: grid '{}'", parts.path.string(), grid->getName());
    if (!grid->transform().isLinear())
        throw InputError(fmt::format("{} has voxels that are not alike; choose another grid for `like`", where));
    const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
    if (box.empty()) throw InputError(fmt::format("{} has no active voxels; choose another grid for `like`", where));
    const py::gil_scoped_acquire acquire;
    py::dict result;
    result["size"] = py::tuple(py::cast(extentOf(box)));
    result["first"] = py::make_tuple(box.min().x(), box.min().y(), box.min().z());
    result["matrix"] = matrixOf(grid->transform());
    return result;
}

/// Raise an error of the module. Text quoted from a file may be invalid UTF-8, which Python refuses.
void raiseAs(const char* type, const Error& error)
{
    PyErr_SetString(py::module_::import("vdblic._core").attr(type).ptr(),
                    printable(withKeywords(error.what())).c_str());
}

} // namespace

openvdb::GridPtrVec chosenGrids(const VdbFile& file, const std::vector<std::string>& names)
{
    openvdb::GridPtrVec grids;
    for (const std::string& name : names) {
        const openvdb::GridBase::Ptr grid = file.find<openvdb::GridBase>(name);
        if (!grid || !isOfNumbers(*grid)) throw file.missing(fmt::format("grid '{}' of numbers or vectors", name));
        grids.push_back(grid);
    }
    if (names.empty()) {
        for (const openvdb::GridBase::Ptr& grid : file.grids)
            if (isOfNumbers(*grid)) grids.push_back(grid);
    }
    if (grids.empty()) throw file.missing("grid of numbers or vectors");
    return grids;
}

void bindFiles(py::module_& module)
{
    py::register_exception<ParameterError>(module, "ParameterError", PyExc_ValueError);
    py::register_exception<InputError>(module, "InputError", PyExc_ValueError);
    py::register_exception<OutputError>(module, "OutputError", PyExc_OSError);
    py::register_local_exception_translator(
        [](std::exception_ptr error) { // NOLINT(performance-unnecessary-value-param)
            try {
                if (error) std::rethrow_exception(error);
            } catch (const ParameterError& told) {
                raiseAs("ParameterError", told);
            } catch (const InputError& told) {
                raiseAs("InputError", told);
            } catch (const OutputError& told) {
                raiseAs("OutputError", told);
            } catch (const std::bad_alloc&) {
                const std::string text = fmt::format(
                    "this takes more than the {} of memory that may be used: cut the domain, or let vdblic_advect "
                    "and vdblic_render do it, which take a scratch file",
                    memoryText(double(memoryLimit())));
                PyErr_SetString(PyExc_MemoryError, text.c_str());
            }
        });

    py::class_<FramePattern>(module, "FramePattern")
        .def(py::init([](const std::filesystem::path& text) { return FramePattern(text.string()); }))
        .def_property_readonly("has_field", &FramePattern::hasField)
        .def("frames_on_disk", &FramePattern::framesOnDisk)
        .def("of_level", &FramePattern::ofLevel)
        .def("path", &FramePattern::path);
    py::class_<InputPaths>(module, "InputPaths")
        .def(py::init<py::function>())
        .def("__iter__", [](py::object self) { return self; })
        .def("__next__", &InputPaths::next);
    py::class_<Sequence>(module, "Sequence")
        .def(py::init([](const std::filesystem::path& pattern, std::string frames, bool clamp,
                         std::optional<std::int64_t> renumber, py::function check) {
            const SequenceParams params{pattern.string(), std::move(frames), clamp, renumber};
            return std::make_unique<Sequence>(params, std::move(check));
        }))
        .def("__iter__", [](py::object self) { return self; })
        .def("__next__", &Sequence::next);
    module.def("files_of", [](const std::filesystem::path& pattern, std::string frames, bool clamp) {
        return filesOf({pattern.string(), std::move(frames), clamp, {}});
    });
    module.def("frame_of_name", &frameOfName);
    module.def("parse_frames", [](const std::string& text) { return parseFrameList(text); });

    module.def("check_extension", &checkExtension);
    module.def("check_output_pattern", &checkOutputPattern);
    module.def("check_outputs", &checkOutputs);
    module.def("check_output", &checkOutput);
    module.def("check_not_input", &checkNotInput);
    module.def("is_finished", &isFinished);
    module.def("verify", &verifyVdb);
    module.def("write_file", [](const std::filesystem::path& path, const py::buffer& data) {
        const py::buffer_info bytes = data.request();
        const py::gil_scoped_release release;
        writeTextFile(path, {static_cast<const char*>(bytes.ptr), std::size_t(bytes.size * bytes.itemsize)});
    });

    module.def("memory_limit", &memoryLimit);
    module.def("read_box", &readBox);
    module.def("read_metadata", &readMetadata);
    module.def("read_over_one_box", &readOverOneBox);
}

} // namespace vdblic::python
