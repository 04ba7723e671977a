#include "textures.h"

#include "grid_arrays.h"
#include "options.h"
#include "vdblic/core/errors.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/run/run_outputs.h"
#include "vdblic/run/texture_file.h"

#include <fmt/format.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

namespace vdblic::python {
namespace {

namespace py = pybind11;

/// Round values as a file in half precision would.
void roundToHalf(openvdb::FloatGrid& grid)
{
    openvdb::tree::LeafManager<openvdb::FloatTree> leaves(grid.tree());
    leaves.foreach ([](openvdb::FloatTree::LeafNodeType& leaf, std::size_t) {
        float* const values = leaf.buffer().data();
        for (openvdb::Index i = 0; i < openvdb::FloatTree::LeafNodeType::SIZE; ++i)
            values[i] = float(openvdb::math::half(values[i]));
    });
}

} // namespace

Parameters advectParameters(AdvectParams& params)
{
    Parameters parameters = parametersOf(params);
    std::erase_if(parameters, [](const Parameter& parameter) {
        static constexpr std::array<std::string_view, 8> kOfFiles = {
            "output", "json", "resume", "restart", "keep_checkpoint", "checkpoint_every", "compression", "renumber"};
        return std::find(kOfFiles.begin(), kOfFiles.end(), parameter.key) != kOfFiles.end();
    });
    return parameters;
}

Textures::Textures(const py::dict& keywords, py::object frames, std::size_t count, py::function tell)
    : mFrames(std::move(frames)), mCaller(std::move(tell)), mCount(count)
{
    AdvectParams params;
    setFrom(keywords, advectParameters(params));
    if (mFrames.is_none() && params.flow.input.pattern == "-")
        throw ParameterError("paths on standard input are for the tools; name a file or a pattern");
    params.output = "texture.vdb"; // which is not written
    params.validate();
    // To the run, frames in memory are one file.
    if (!mFrames.is_none()) params.flow.input = {.pattern = "frames", .steadyFrames = params.flow.input.steadyFrames};
    const FramesAround around = mFrames.is_none() ? framesAround(params.flow.input) : FramesAround{};
    mPlan.emplace(resolve(std::move(params), around));
    if (const std::string leadIn = leadInText(*mPlan); !leadIn.empty()) mCaller.say(leadIn);
    mRun.emplace(*mPlan, source(), mCaller, mAlone, static_cast<RunObserver&>(*this));
}

void Textures::frameRead(const VelocityFrame& frame)
{
    if (!mFirst) mFirst = frame.file.frame;
}

FrameSource Textures::source()
{
    const int steadyFrames = mPlan->input.steadyFrames;
    if (!mFrames.is_none()) {
        FrameSource source = [this] { return nextFrame(); };
        if (steadyFrames == 1) return source;
        mCount = std::size_t(steadyFrames);
        return steadySource(std::move(source), steadyFrames);
    }
    return openSequence(mPlan->input, mNoLines, mCount);
}

/// A frame of the iterator, whose errors become the caller's.
std::optional<FrameFile> Textures::nextFrame()
{
    const py::gil_scoped_acquire acquire;
    PyObject* const taken = PyIter_Next(mFrames.ptr());
    if (PyErr_Occurred()) throw py::error_already_set();
    if (!taken) return std::nullopt;
    const auto [grids, metadata] = py::reinterpret_steal<py::object>(taken).cast<std::pair<py::list, py::dict>>();
    const std::string name = fmt::format("frame {}", ++mTaken);
    return FrameFile{mTaken, name, std::make_shared<const VdbFile>(toVolume(grids, metadata, name))};
}

py::object Textures::next()
{
    std::optional<TextureFile> file;
    {
        const py::gil_scoped_release release;
        if (mNext) {
            ++*mNext;
        } else {
            mNext = mRun->begin();
        }
        if (*mNext != mRun->end()) {
            TextureFrame& made = **mNext;
            const std::int64_t frame = made.frame.file.frame;
            file = makeTextureFile(*mPlan, made, textureNumber(*mFirst, frame, mPlan->substeps(), made.substep));
            if (mRun->isDone()) tellSteps(mRun->steps());
        }
    }
    if (!file) return py::none();
    py::list grids;
    for (const openvdb::GridBase::ConstPtr& made : file->grids) {
        const openvdb::GridBase::Ptr grid = std::const_pointer_cast<openvdb::GridBase>(made);
        if (const auto scalar = openvdb::gridPtrCast<openvdb::FloatGrid>(grid); scalar && grid->saveFloatAsHalf())
            roundToHalf(*scalar);
        grids.append(toDictionary(*grid));
    }
    return py::make_tuple(grids, toDictionary(file->metadata));
}

void Textures::stepDone(const RunPosition& position, const VelocityFrame& /*next*/)
{
    tellSteps(position.steps);
}

void Textures::tellSteps(std::uint64_t done)
{
    const std::size_t steps = mCount == 0 ? 0 : (mCount - 1) * std::size_t(mPlan->substeps()) + 1;
    mCaller.progress(done, steps == 0 ? 0 : steps + mPlan->prerollSteps());
}

} // namespace vdblic::python
