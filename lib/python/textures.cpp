#include "textures.h"

#include "grid_arrays.h"
#include "metadata.h"
#include "options.h"
#include "ranks.h"
#include "vdblic/core/errors.h"
#include "vdblic/distributed/leaf_delivery.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/run/parameter_texts.h"
#include "vdblic/run/run_checkpoint.h"
#include "vdblic/run/run_outputs.h"
#include "vdblic/run/texture_file.h"

#include <fmt/format.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <exception>
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

std::unique_ptr<Exchange> exchangeOf(const py::object& ranks)
{
    if (ranks.is_none()) return std::make_unique<OneProcess>();
    return std::make_unique<Ranks>(ranks);
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

Textures::Textures(const py::dict& keywords, py::object frames, std::size_t count, py::function tell,
                   const py::object& ranks, std::optional<std::filesystem::path> resume)
    : mFrames(std::move(frames)), mCaller(std::move(tell)), mCount(count), mExchange(exchangeOf(ranks)),
      mResume(std::move(resume))
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
    mRun.emplace(*mPlan, source(), mCaller, *mExchange, static_cast<RunObserver&>(*this));
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

std::optional<RunPosition> Textures::begins(VelocitySequence& /*flow*/)
{
    if (!mResume) return std::nullopt;
    mResumed = readCheckpoint(*mResume, parameterTexts(*mPlan));
    mFirst = 1;
    mTaken = std::int64_t(mPlan->framesDone(mResumed->position.steps));
    return mResumed->position;
}

void Textures::opened(const VelocityFrame& first, bool /*isOnly*/, FlowTexture& texture)
{
    if (!mResumed) return;
    RunOutputs outputs(*mPlan, *mResume);
    std::vector<std::filesystem::path> finished(mPlan->texturesDone(mResumed->position.steps));
    RunCheckpoint(*mPlan, outputs, mCaller, *mExchange).restore(*mResumed, first, texture, finished);
    mResumed.reset(); // with the state that it holds
}

void Textures::save(const std::filesystem::path& path, const std::vector<std::string>& inputs)
{
    if (!mStep) throw ParameterError("there is no step to save; the second frame makes the first one");
    const py::gil_scoped_release release;
    mExchange->together([&] {
        RunOutputs outputs(*mPlan, path);
        RunCheckpoint checkpoint(*mPlan, outputs, mCaller, *mExchange);
        for (const std::string& input : inputs)
            checkpoint.noteInput({}, input);
        checkpoint.stepDone(mStep->position, mStep->next);
        checkpoint.write(mRun->texture());
    });
}

/// The next texture, whole at rank 0.
std::optional<TextureFile> Textures::make()
{
    if (mNext) {
        ++*mNext;
    } else {
        mNext = mRun->begin();
    }
    if (*mNext == mRun->end()) return std::nullopt;
    TextureFrame& made = **mNext;
    const std::int64_t frame = made.frame.file.frame;
    TextureFile file =
        makeTextureFile(*mPlan, made, textureNumber(*mFirst, frame, mPlan->substeps(), made.substep), *mExchange, 0);
    if (mRun->isDone()) tellSteps(mRun->steps());
    if (mExchange->isAlone()) return file;
    for (std::size_t i = 0; i < file.computed; ++i) {
        const Domain& domain = i < file.onTexture ? *file.domain : *made.frame.domain.velocity;
        file.grids[i] = gathered(*mExchange, domain, *file.grids[i]);
    }
    if (!mExchange->isFirst()) file.grids.clear();
    return file;
}

py::object Textures::next()
{
    std::optional<TextureFile> file;
    try {
        const py::gil_scoped_release release;
        file = make();
    } catch (...) {
        mExchange->fail(std::current_exception());
        throw;
    }
    if (!file) return py::none();
    openvdb::GridPtrVec grids;
    for (const openvdb::GridBase::ConstPtr& made : file->grids) {
        const openvdb::GridBase::Ptr grid = std::const_pointer_cast<openvdb::GridBase>(made);
        if (const auto scalar = openvdb::gridPtrCast<openvdb::FloatGrid>(grid); scalar && grid->saveFloatAsHalf())
            roundToHalf(*scalar);
        grids.push_back(grid);
    }
    file->grids.clear();
    return py::make_tuple(toList(std::move(grids)), toDictionary(file->metadata));
}

void Textures::stepDone(const RunPosition& position, const VelocityFrame& next)
{
    mStep = {position, next};
    tellSteps(position.steps);
}

void Textures::tellSteps(std::uint64_t done)
{
    const std::size_t steps = mCount == 0 ? 0 : (mCount - 1) * std::size_t(mPlan->substeps()) + 1;
    mCaller.progress(done, steps == 0 ? 0 : steps + mPlan->prerollSteps());
}

} // namespace vdblic::python
