#include "files.h"
#include "grid_arrays.h"
#include "options.h"
#include "picture.h"
#include "textures.h"
#include "vdblic/coherence/coherence_report.h"
#include "vdblic/coherence/coherence_sequence.h"
#include "vdblic/compare/compare.h"
#include "vdblic/compare/report.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/version.h"
#include "vdblic/field/box_domain.h"
#include "vdblic/field/synth.h"
#include "vdblic/io/vdb_file.h"

#include <openvdb/openvdb.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace vdblic::python {
namespace {

namespace py = pybind11;

py::tuple readVolume(const std::string& path)
{
    VdbFile file;
    {
        const py::gil_scoped_release release;
        file = readVdb(path);
    }
    py::list grids;
    for (openvdb::GridBase::Ptr& grid : file.grids) {
        if (isOfNumbers(*grid)) grids.append(toDictionary(*grid));
        grid.reset();
    }
    return py::make_tuple(grids, toDictionary(file.metadata));
}

void writeVolume(const std::string& path, const py::list& dictionaries, const py::dict& metadata,
                 const std::string& compression, bool half)
{
    const openvdb::GridPtrVec made = toGrids(dictionaries);
    openvdb::GridCPtrVec grids(made.begin(), made.end());
    for (const auto& grid : made)
        grid->setSaveFloatAsHalf(half);
    const openvdb::MetaMap fileMetadata = toMetadata(metadata);
    const VdbCompression kind = valueOf<VdbCompression>(compression);
    const py::gil_scoped_release release;
    writeVdb(path, grids, fileMetadata, kind);
}

/// The picture of a volume. The array shares the image's memory.
py::array_t<float> render(Picture& picture, const py::list& dictionaries, const py::dict& metadata, std::int64_t frame)
{
    const VdbFile volume{toGrids(dictionaries), toMetadata(metadata), "volume"};
    auto image = std::make_unique<Image>();
    {
        const py::gil_scoped_release release;
        *image = picture.of(volume, frame);
    }
    const std::array<py::ssize_t, 3> shape = {image->size.y, image->size.x, 4};
    const float* pixels = &image->pixels.data()->x;
    const py::capsule owner(image.release(), [](void* made) { delete static_cast<Image*>(made); });
    return py::array_t<float>(shape, pixels, owner);
}

py::object synth(const std::string& flow, const BoxSize& size, double time, double voxelSize)
{
    openvdb::Vec3SGrid::Ptr grid;
    {
        const py::gil_scoped_release release;
        checkBoxSize(size);
        checkVoxelSize(voxelSize);
        grid = sampleFlow(flowInBox(findAnalyticFlow(flow), size, voxelSize), *boxDomain(size),
                          *openvdb::math::Transform::createLinearTransform(voxelSize), time);
    }
    return toDictionary(*grid);
}

std::string diff(const std::string& a, const std::string& b, const py::dict& keywords)
{
    CompareSequencesParams params{a, b, "", "", false, "", {}};
    setFrom(keywords, parametersOf(params));
    const py::gil_scoped_release release;
    Reporter silent;
    return toJson(compareSequences(params, silent), params.compare);
}

std::string coherence(const std::string& velocity, const std::string& texture, const py::dict& keywords)
{
    SequenceCoherenceParams params;
    params.flow.input.pattern = velocity;
    params.texture = texture;
    setFrom(keywords, parametersOf(params));
    const py::gil_scoped_release release;
    Reporter silent;
    return toJson(coherenceOfSequence(params, silent), params);
}

/// What the keyword arguments of a function are. @param function advect, picture, diff or coherence
py::list parametersOfFunction(const std::string& function)
{
    AdvectParams run;
    RenderParams picture = defaultRenderParams();
    CompareSequencesParams compared;
    SequenceCoherenceParams measured;
    return described(function == "advect"    ? advectParameters(run)
                     : function == "picture" ? pictureParametersOf(picture)
                     : function == "diff"    ? parametersOf(compared)
                                             : parametersOf(measured));
}

} // namespace
} // namespace vdblic::python

PYBIND11_MODULE(_core, module)
{
    using namespace vdblic;
    using namespace vdblic::python;
    openvdb::initialize();
    module.attr("__version__") = kVersion;
    bindFiles(module);
    module.def("read", &readVolume);
    module.def("write", &writeVolume);
    module.def("synth", &synth);
    module.def("diff", &diff);
    module.def("coherence", &coherence);
    module.def("parameters", &parametersOfFunction);
    py::class_<Textures>(module, "Textures")
        .def(py::init([](const py::dict& options, py::object frames, py::function tell) {
            return std::make_unique<Textures>(options, std::move(frames), std::move(tell));
        }))
        .def("next", &Textures::next);
    py::class_<Picture>(module, "Picture")
        .def(py::init([](const py::dict& options) { return std::make_unique<Picture>(renderParams(options)); }))
        .def("render", &render);
}
