#include "vdblic/run/run_checkpoint.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/paging.h"
#include "vdblic/distributed/partition.h"
#include "vdblic/flow/velocity_sequence.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/checkpoint_mark.h"
#include "vdblic/io/file_stamp.h"
#include "vdblic/io/vdb_header.h"
#include "vdblic/methods/flow_texture.h"
#include "vdblic/run/advect_plan.h"
#include "vdblic/run/run_outputs.h"
#include "vdblic/run/texture_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <new>
#include <numeric>
#include <system_error>
#include <utility>

namespace vdblic {
namespace {

/// A part of a texture's state in a checkpoint.
struct SavedPart {
    VdbFile file;
    openvdb::CoordBBox box;
};
SavedPart stateOf(const FlowTexture& texture, std::size_t part, const openvdb::math::Transform& transform)
{
    const auto* const memory = dynamic_cast<const TextureMemory*>(&texture);
    TextureMemory::Saved saved = memory ? memory->save(part) : TextureMemory::Saved{};
    for (const auto& grid : saved.grids)
        grid->setTransform(transform.copy());
    return {{std::move(saved.grids), {}, {}}, saved.box};
}

/// Without a memory the checkpoint holds the position of the run alone.
std::size_t partsOf(const FlowTexture& texture)
{
    const auto* const memory = dynamic_cast<const TextureMemory*>(&texture);
    return memory ? memory->parts() : 1;
}

/// Remove a checkpoint, but no other file.
void removeCheckpoint(const std::filesystem::path& path, std::error_code& error)
{
    if (isCheckpoint(path)) std::filesystem::remove(path, error);
    removeLeftovers(path);
}

} // namespace

RunCheckpoint::RunCheckpoint(const AdvectPlan& plan, RunOutputs& outputs, Reporter& reporter, Exchange& exchange)
    : mPlan(plan), mOutputs(outputs), mReporter(reporter), mExchange(exchange), mParameters(parameterTexts(plan)),
      mSchedule(plan.params.checkpointEvery)
{
}

std::optional<Checkpoint> RunCheckpoint::find()
{
    const bool isThere = isFinished(mOutputs.checkpoint()), isKnown = isCheckpoint(mOutputs.checkpoint());
    mExchange.agree(); // before rank 0 removes it
    if (isThere && !isKnown) refuseForeign();
    if (isThere && !mPlan.params.resume && !mPlan.params.restart) {
        throw ParameterError(
            fmt::format("{}: an earlier run left this checkpoint; go on from it with `resume`, or remove "
                        "it and start from the beginning with `restart`",
                        mOutputs.checkpoint().string()));
    }
    if (!mPlan.params.resume) return std::nullopt;
    if (!isThere) {
        mReporter.say(fmt::format("no {}: starting from the beginning", mOutputs.checkpoint().string()));
        return std::nullopt;
    }
    Checkpoint checkpoint = readCheckpoint(mOutputs.checkpoint(), mParameters);
    mExpected = checkpoint.inputs;
    return checkpoint;
}

/// Refuse to read or replace a foreign file with the checkpoint's name.
void RunCheckpoint::refuseForeign() const
{
    const std::filesystem::path& path = mOutputs.checkpoint();
    std::string found = fmt::format("{}: is no checkpoint of vdblic_advect", path.string());
    try {
        (void)readVdbHeader(path);
    } catch (const InputError& error) {
        found = fmt::format("{}; it is damaged, or no checkpoint of vdblic_advect", error.what());
    }
    if (mPlan.params.resume) throw InputError(found + ": copy it again, or move it away to start from the beginning");
    throw ParameterError(found + ", and one would replace it: move it away, or give another `output`");
}

std::vector<std::filesystem::path> RunCheckpoint::passOver(const Checkpoint& checkpoint, VelocitySequence& flow)
{
    const int substeps = mPlan.substeps();
    const std::uint64_t frames = mPlan.framesDone(checkpoint.position.steps);
    std::vector<std::filesystem::path> outputs;
    for (std::uint64_t i = 0; i < frames; ++i) {
        if (i >= mExpected.size()) {
            refuseCheckpoint(mOutputs.checkpoint(),
                             fmt::format("lists {} inputs, fewer than it has frames done: copy it again", i));
        }
        const std::optional<FrameFile> file = flow.skip();
        if (!file) {
            mReporter.checkStop();
            refuseCheckpoint(mOutputs.checkpoint(),
                             fmt::format("has {} frames done, the input has only {} now: give all of them", frames, i));
        }
        noteInput(file->path, flow.stampOf(*file));
        if (i < std::uint64_t(mPlan.leadIn)) continue;
        mOutputs.startAt(file->frame);
        addFinished(*file, substeps, outputs);
    }
    return outputs;
}

/// Add the outputs of a frame's first substeps. @throws InputError if one is missing
void RunCheckpoint::addFinished(const FrameFile& file, int substeps, std::vector<std::filesystem::path>& outputs) const
{
    for (int substep = 0; substep < substeps; ++substep) {
        outputs.push_back(mOutputs.texture(file.frame, substep));
        if (!mExchange.isFirst()) continue; // the first rank reports them
        const std::string fault = faultOf(outputs.back(), mOutputs.number(file.frame, substep), mPlan);
        if (fault.empty()) continue;
        refuseCheckpoint(mOutputs.checkpoint(), fmt::format("tells that {} was finished, but {}: put it back",
                                                            outputs.back().string(), fault));
    }
}

void RunCheckpoint::checkEnds(const Checkpoint& checkpoint, const FrameFile& last) const
{
    if (mPlan.substep(checkpoint.position.steps) == 0) return;
    refuseCheckpoint(
        mOutputs.checkpoint(),
        fmt::format("is past frame {}, but the input ends there: give the frame range of the first run", last.frame));
}

void RunCheckpoint::restore(const Checkpoint& checkpoint, const VelocityFrame& frame, FlowTexture& texture,
                            std::vector<std::filesystem::path>& outputs) const
{
    const RunPosition& position = checkpoint.position;
    if (mPlan.framesDone(position.steps) >= std::uint64_t(mPlan.leadIn))
        addFinished(frame.file, mPlan.substep(position.steps), outputs);
    auto state = checkpoint.states.begin();
    auto part = checkpoint.parts.begin();
    const auto isElsewhere = [&](const CheckpointPart& one) {
        return frame.partition && !frame.partition->textureBox(mExchange.rank()).voxels.hasOverlap(one.box);
    };
    const auto next = [&]() -> std::optional<VdbFile> { // only one is in memory at a time
        if (state != checkpoint.states.end()) return *state++;
        part = std::find_if_not(part, checkpoint.parts.end(), isElsewhere);
        return part != checkpoint.parts.end() ? std::optional(readPart(checkpoint, *part++)) : std::nullopt;
    };
    try {
        if (auto* const memory = dynamic_cast<TextureMemory*>(&texture))
            memory->restore(position.steps, position.interval / mPlan.substeps(), frame.domain.texture, next);
    } catch (const InputError& error) {
        refuseCheckpoint(mOutputs.checkpoint(), fmt::format("{}: copy it again", error.what()));
    }
    mReporter.say(fmt::format("{}: {} textures are done", mOutputs.checkpoint().string(), outputs.size()));
}

VdbFile RunCheckpoint::readPart(const Checkpoint& checkpoint, const CheckpointPart& part) const
{
    if (!isFinished(part.path)) {
        refuseCheckpoint(mOutputs.checkpoint(),
                         fmt::format("needs {}, which is not there: put it back", part.path.string()));
    }
    Checkpoint read = readCheckpoint(part.path, mParameters);
    if (read.position.steps != checkpoint.position.steps || read.states.empty())
        refuseCheckpoint(mOutputs.checkpoint(), fmt::format("does not belong to {}", part.path.string()));
    return std::move(read.states.front());
}

void RunCheckpoint::noteInput(const std::filesystem::path& path, const std::string& stamp)
{
    const std::size_t index = mInputs.size();
    mInputs.push_back(stamp);
    if (index >= mExpected.size() || mExpected[index] == stamp) return;
    throw InputError(fmt::format("{}: differs from what the interrupted run read: {}; put that back, or delete {} to "
                                 "start from the beginning",
                                 path.string(), stampDifference(mExpected[index], stamp),
                                 mOutputs.checkpoint().string()));
}

void RunCheckpoint::stepDone(const RunPosition& position, const VelocityFrame& frame)
{
    mUnsaved = {position, frame.textureTransform()};
    mSchedule.stepDone();
}

void RunCheckpoint::write(const FlowTexture& texture)
{
    const Unsaved unsaved = std::move(mUnsaved.value());
    mUnsaved.reset();
    const auto start = CheckpointSchedule::Clock::now();
    Checkpoint checkpoint{unsaved.position, mInputs, {}};
    // A step depends on the frames at both ends of its interval, on none after them.
    const std::size_t lastStep = std::max(unsaved.position.steps, std::uint64_t(1)) - 1;
    checkpoint.inputs.resize(std::min<std::size_t>(mPlan.framesDone(lastStep) + 2, mInputs.size()));
    try {
        if (mExchange.isAlone() && partsOf(texture) == 1) {
            checkpoint.states.push_back(stateOf(texture, 0, *unsaved.transform).file);
            writeCheckpoint(mOutputs.checkpoint(), checkpoint, mParameters);
            removeParts({}); // of an earlier, larger state
        } else {
            writeParts(texture, unsaved, std::move(checkpoint));
        }
    } catch (const std::bad_alloc&) {
        paging::checkScratch();
        throw InputError(fmt::format("{}: takes more than the {} of memory that may be used: raise `max_memory`, or "
                                     "give `checkpoint_every` 0 to do without",
                                     mOutputs.checkpoint().string(), memoryText(double(memoryLimit()))));
    } catch (const OutputError& error) {
        throw OutputError(fmt::format("{}; `checkpoint_every` 0 does without checkpoints", error.what()));
    }
    mSchedule.wrote(CheckpointSchedule::Clock::now() - start);
}

/// Every rank writes its parts, then rank 0 the file that lists them: until then the previous checkpoint is valid.
void RunCheckpoint::writeParts(const FlowTexture& texture, const Unsaved& unsaved, Checkpoint checkpoint)
{
    const std::vector<std::size_t> counts = mExchange.join(std::vector<std::size_t>{partsOf(texture)});
    const std::size_t first = std::accumulate(counts.begin(), counts.begin() + mExchange.rank(), std::size_t(0));
    const auto path = [&](std::size_t part) { return mOutputs.checkpointPart(unsaved.position.steps, part); };
    std::vector<openvdb::CoordBBox> boxes;
    try {
        for (std::size_t part = 0; part < partsOf(texture); ++part) {
            SavedPart saved = stateOf(texture, part, *unsaved.transform);
            boxes.push_back(saved.box);
            checkpoint.states.push_back(std::move(saved.file));
            writeCheckpoint(path(first + part), checkpoint, mParameters);
            checkpoint.states.clear();
        }
        for (const openvdb::CoordBBox& box : mExchange.join(boxes))
            checkpoint.parts.push_back({path(checkpoint.parts.size()), box});
        if (mExchange.isFirst()) writeCheckpoint(mOutputs.checkpoint(), checkpoint, mParameters);
        mExchange.agree();
    } catch (...) {
        std::error_code ignored;
        for (std::size_t part = 0; part < boxes.size(); ++part)
            removeCheckpoint(path(first + part), ignored);
        throw;
    }
    if (mExchange.isFirst()) removeParts(unsaved.position.steps);
}

/// Remove the parts of checkpoints. @param but steps of the parts to keep
void RunCheckpoint::removeParts(std::optional<std::uint64_t> but) const
{
    for (const std::filesystem::path& part : mOutputs.checkpointParts(but)) {
        std::error_code error;
        removeCheckpoint(part, error);
        if (error) throw OutputError(fmt::format("{}: cannot be removed: {}", part.string(), error.message()));
    }
}

void RunCheckpoint::remove() const
{
    if (!mExchange.isFirst()) return;
    std::error_code error;
    removeCheckpoint(mOutputs.checkpoint(), error);
    if (!error) {
        removeParts({});
        return;
    }
    throw OutputError(fmt::format("{}: cannot be removed: {}", mOutputs.checkpoint().string(), error.message()));
}

} // namespace vdblic
