#include "bindings.h"
#include "caller.h"
#include "grid_arrays.h"
#include "metadata.h"
#include "options.h"
#include "renderer.h"
#include "textures.h"
#include "vdblic/camera/camera_path.h"
#include "vdblic/coherence/coherence_report.h"
#include "vdblic/coherence/coherence_sequence.h"
#include "vdblic/compare/compare.h"
#include "vdblic/compare/report.h"
#include "vdblic/core/crash_guard.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/hazard.h"
#include "vdblic/core/nearest_name.h"
#include "vdblic/core/threads.h"
#include "vdblic/core/version.h"
#include "vdblic/field/box_domain.h"
#include "vdblic/field/synth.h"
#include "vdblic/film/film.h"
#include "vdblic/image/image_file.h"
#include "vdblic/io/vdb_file.h"

#include <fmt/format.h>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <openvdb/openvdb.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <tbb/global_control.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace vdblic::python {
namespace {

namespace py = pybind11;

using Pixels = py::array_t<float, py::array::c_style | py::array::forcecast>;

py::tuple readVolume(const std::filesystem::path& path)
{
    VdbFile file;
    {
        const py::gil_scoped_release release;
        file = readVdb(path);
    }
    return py::make_tuple(toList(std::move(file.grids)), toDictionary(file.metadata));
}

void writeVolume(const std::filesystem::path& path, const py::list& dictionaries, const py::dict& metadata,
                 const std::string& compression, bool half)
{
    const VdbFile volume = toVolume(dictionaries, metadata, "");
    const openvdb::GridCPtrVec grids(volume.grids.begin(), volume.grids.end());
    for (const auto& grid : volume.grids)
        grid->setSaveFloatAsHalf(half);
    const auto kind = valueOf<VdbCompression>(compression);
    const py::gil_scoped_release release;
    writeVdb(path, grids, volume.metadata, kind);
}

/// The picture of a volume. The array shares the image's memory.
py::array_t<float> render(Renderer& renderer, const py::list& dictionaries, const py::dict& metadata,
                          std::int64_t frame)
{
    const VdbFile volume = toVolume(dictionaries, metadata, "the texture");
    auto image = std::make_unique<Image>();
    {
        const py::gil_scoped_release release;
        *image = renderer.of(volume, frame);
    }
    const std::array<py::ssize_t, 3> shape = {image->size.y, image->size.x, 4};
    const float* pixels = &image->pixels.data()->x;
    const py::capsule owner(image.release(), [](void* made) { delete static_cast<Image*>(made); });
    return py::array_t<float>(shape, pixels, owner);
}

/// A picture from Python. The rows have 4 numbers a pixel.
Image imageOf(const Pixels& pixels)
{
    Image image{{int(pixels.shape(1)), int(pixels.shape(0))}, std::vector<glm::vec4>(std::size_t(pixels.size() / 4))};
    std::memcpy(image.pixels.data(), pixels.data(), std::size_t(pixels.size()) * sizeof(float));
    return image;
}

/// @param colors red, green and blue; or six numbers, for bottom and top
Background backgroundOf(const std::vector<double>& colors)
{
    const auto color = [&](std::size_t first) {
        return glm::dvec3(colors[first], colors[first + 1], colors[first + 2]);
    };
    if (colors.size() != 3 && colors.size() != 6)
        throw ParameterError(fmt::format("`background` has {} numbers; a background has 3 or 6", colors.size()));
    Background result{.color = color(0)};
    if (colors.size() == 6) result.top = color(3);
    return result;
}

py::bytes png(const Pixels& pixels, const std::vector<double>& background)
{
    const Image image = imageOf(pixels);
    const Background behind = backgroundOf(background);
    std::string file;
    {
        const py::gil_scoped_release release;
        file = encodePng(image, behind);
    }
    return file;
}

/// The bytes of an .exr file. The pixels are over their background.
py::bytes exr(const Pixels& pixels, const std::string& precision)
{
    const Image image = imageOf(pixels);
    ExrParams params{.precision = precision};
    params.validate();
    std::string file;
    {
        const py::gil_scoped_release release;
        file = encodeExr(image, {}, {}, params);
    }
    return file;
}

py::array_t<std::uint8_t> displayed(const Pixels& pixels, const std::vector<double>& background)
{
    const Image image = imageOf(pixels);
    py::array_t<std::uint8_t> result({image.size.y, image.size.x, 3});
    const std::string bytes = displayBytes(image, backgroundOf(background));
    std::memcpy(result.mutable_data(), bytes.data(), bytes.size());
    return result;
}

/// The properties of the camera that a file of key frames sets.
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

py::list synth(const std::string& flow, const std::optional<BoxSize>& size, double time, double voxelSize)
{
    openvdb::GridPtrVec grids;
    {
        const py::gil_scoped_release release;
        grids = SynthFlow(flow, size, voxelSize).at(time);
    }
    py::list result;
    for (const openvdb::GridBase::Ptr& grid : grids)
        result.append(toDictionary(*grid));
    return result;
}

double synthDt(const std::string& flow, double voxelSize)
{
    return SynthFlow::dt(findAnalyticFlow(flow), voxelSize);
}

std::string diff(const std::string& a, const std::string& b, const py::dict& keywords, const py::function& tell)
{
    CompareSequencesParams params{a, b, "", "", false, "", {}};
    setFrom(keywords, parametersOf(params));
    Caller caller(tell);
    const py::gil_scoped_release release;
    return toJson(compareSequences(params, caller), params.compare);
}

/// A volume to compare, which is a path or a pair of grids and metadata.
VdbFile volumeOf(const py::object& source, const char* name)
{
    if (py::isinstance<py::tuple>(source)) {
        const auto [grids, metadata] = source.cast<std::pair<py::list, py::dict>>();
        return toVolume(grids, metadata, name);
    }
    const auto path = source.cast<std::string>();
    const py::gil_scoped_release release;
    return readVdb(path);
}

/// The report on two volumes.
std::string diffOfVolumes(const py::object& sourceA, const py::object& sourceB, const py::dict& keywords)
{
    CompareSequencesParams params;
    setFrom(keywords, parametersOf(params));
    if (!params.frames.empty()) throw ParameterError("`frames` selects files; a volume in memory has none");
    const VdbFile a = volumeOf(sourceA, "a"), b = volumeOf(sourceB, "b");
    const py::gil_scoped_release release;
    const FileDifference files = compareVolumes(a, b, params.compare);
    return toJson({files.pathA, files.pathB, {{1, true, true, files}}}, params.compare);
}

std::string coherence(const std::string& velocity, const std::string& texture, const py::dict& keywords,
                      const py::function& tell)
{
    SequenceCoherenceParams params;
    params.flow.input.pattern = velocity;
    params.texture = texture;
    setFrom(keywords, parametersOf(params));
    Caller caller(tell);
    const py::gil_scoped_release release;
    return toJson(coherenceOfSequence(params, caller), params);
}

void film(const std::string& velocity, const std::string& output, const py::dict& keywords, const py::function& tell)
{
    FilmParams params;
    params.input.pattern = velocity;
    params.output = output;
    setFrom(keywords, parametersOf(params));
    Caller caller(tell);
    const py::gil_scoped_release release;
    makeFilm(params, caller);
}

/// The keyword arguments of a function. @param function advect, picture, render, film, diff or coherence
py::list parametersOfFunction(const std::string& function)
{
    AdvectParams run;
    RenderParams render;
    PictureParams picture;
    CompareSequencesParams compared;
    SequenceCoherenceParams measured;
    FilmParams filmed;
    return described(function == "advect"    ? advectParameters(run)
                     : function == "film"    ? parametersOf(filmed)
                     : function == "picture" ? parametersOf(picture)
                     : function == "render"  ? parametersOf(render)
                     : function == "diff"    ? parametersOf(compared)
                                             : parametersOf(measured));
}

/// Limit TBB to the threads that the system starts; it aborts the process where a thread cannot be started.
void useStartableThreads()
{
    const std::size_t wanted = threadCount(), startable = 1 + startableThreads(wanted - 1);
    if (startable >= wanted) return;
    // For ever: at its end TBB would start the threads that it was denied.
    static const auto* const kThreads =
        new tbb::global_control(tbb::global_control::max_allowed_parallelism, startable);
    (void)kThreads;
}

/// `with Parsing(file, library, is_timed)`: while a library of Python parses the file, a crash, and if it is timed an
/// endless loop, is told as the file's (core/crash_guard.h).
class Parsing {
  public:
    Parsing(const std::filesystem::path& file, std::string library, bool isTimed)
        : mFile(file.string()), mLibrary(std::move(library)), mIsTimed(isTimed)
    {
    }
    void enter()
    {
        std::error_code error;
        const std::uintmax_t size = std::filesystem::file_size(mFile, error);
        mHazard.emplace(mFile, mIsTimed && !error ? size : Hazard::kAnySize, mLibrary.c_str());
    }
    void leave() { mHazard.reset(); }

  private:
    std::string mFile, mLibrary;
    bool mIsTimed;
    std::optional<Hazard> mHazard;
};

} // namespace
} // namespace vdblic::python

PYBIND11_MODULE(_core, module)
{
    using namespace vdblic;
    using namespace vdblic::python;
    openvdb::initialize();
    useStartableThreads();
    module.attr("__version__") = kVersion;
    pybind11::class_<CameraKeys>(module, "CameraFile", "The key frames of a camera (docs/formats.md).")
        .def(pybind11::init([](const std::filesystem::path& path) { return readCameraKeys(path); }))
        .def("at", &cameraAt);
    bindFiles(module);
    bindGridHeaders(module);
    bindLevels(module);
    bindLines(module);
    bindSolids(module);
    module.def("guard_against_crashes", [](const std::string& tool) { guardAgainstCrashes(tool); });
    py::class_<Parsing>(module, "Parsing")
        .def(py::init<const std::filesystem::path&, std::string, bool>())
        .def("__enter__", &Parsing::enter)
        .def("__exit__", [](Parsing& self, const py::args&) { self.leave(); });
    module.def("read", &readVolume);
    module.def("write", &writeVolume);
    module.def("synth", &synth);
    module.def("synth_dt", &synthDt);
    module.def("diff", &diff);
    module.def("diff_volumes", &diffOfVolumes);
    module.def("png", &png);
    module.def("exr", &exr);
    module.def("displayed", &displayed);
    module.def("coherence", &coherence);
    module.def("film", &film);
    module.def("nearest_name", &nearestName);
    module.def("parameters", &parametersOfFunction);
    py::class_<Textures>(module, "Textures")
        .def(py::init<const py::dict&, py::object, std::size_t, py::function, const py::object&,
                      std::optional<std::filesystem::path>>(),
             py::arg("options"), py::arg("frames"), py::arg("count"), py::arg("tell"), py::arg("ranks") = py::none(),
             py::arg("resume") = py::none())
        .def_property_readonly("needed", &Textures::needed)
        .def("next", &Textures::next)
        .def("save", &Textures::save);
    py::class_<Renderer>(module, "Picture")
        .def(py::init([](const py::dict& options) { return std::make_unique<Renderer>(options); }))
        .def_property_readonly("background",
                               [](const Renderer& renderer) {
                                   const Background& background = renderer.plan().background;
                                   std::vector<double> numbers;
                                   for (const double down : {1.0, 0.0}) {
                                       const glm::dvec3 color = background.at(down);
                                       if (down == 1 || background.top)
                                           numbers.insert(numbers.end(), {color.x, color.y, color.z});
                                   }
                                   return numbers;
                               })
        .def_property_readonly("texture", [](const Renderer& renderer) { return renderer.plan().texture; })
        .def("render", &render);
    py::class_<openvdb::Metadata, openvdb::Metadata::Ptr>(module, "Metadata")
        .def("__repr__", &openvdb::Metadata::str)
        .def("__eq__", [](const openvdb::Metadata& a, const openvdb::Metadata& b) { return a == b; });
}
