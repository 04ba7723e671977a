#include "vdblic/lic/run_checkpoint.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/file_stamp.h"
#include "vdblic/lic/advect_params.h"
#include "vdblic/lic/flow_sequence.h"
#include "vdblic/lic/flow_texture.h"
#include "vdblic/lic/run_outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <new>
#include <system_error>
#include <utility>

namespace vdblic {

RunCheckpoint::RunCheckpoint(const AdvectParams& params, RunOutputs& outputs, Reporter& reporter, Exchange& exchange)
    : mParams(params), mOutputs(outputs), mReporter(reporter), mExchange(exchange), mParameters(parameterTexts(params)),
      mSchedule(params.checkpointEvery)
{
}

std::optional<Checkpoint> RunCheckpoint::find()
{
    const bool isThere = isFinished(mOutputs.checkpoint());
    mExchange.agree(); // before rank 0 removes it
    if (isThere && !mParams.resume && !mParams.restart) {
        throw ParameterError(
            fmt::format("{}: an earlier run left this checkpoint; go on from it with `resume`, or remove "
                        "it and start from the beginning with `restart`",
                        mOutputs.checkpoint().string()));
    }
    if (!mParams.resume) return std::nullopt;
    if (!isThere) {
        mReporter.say(fmt::format("no {}: starting from the beginning", mOutputs.checkpoint().string()));
        return std::nullopt;
    }
    Checkpoint before = readCheckpoint(mOutputs.checkpoint(), mParameters);
    mExpected = before.inputs;
    return before;
}

std::vector<std::filesystem::path> RunCheckpoint::passOver(const Checkpoint& before, FlowSequence& flow)
{
    const int substeps = mParams.scatter.substeps;
    const std::uint64_t frames = mParams.framesDone(before.position.steps);
    std::vector<std::filesystem::path> outputs;
    for (std::uint64_t i = 0; i < frames; ++i) {
        const std::optional<FrameFile> file = flow.skip();
        if (!file) {
            mReporter.checkStop();
            refuseCheckpoint(mOutputs.checkpoint(),
                             fmt::format("has {} frames done, the input has only {} now: give all of them", frames, i));
        }
        noteInput(file->path, flow.stampOf(*file));
        if (i < std::uint64_t(mParams.leadInFrames())) continue;
        mOutputs.startAt(file->frame);
        addFinished(*file, substeps, outputs);
    }
    return outputs;
}

/// Add the outputs of a frame's first substeps. @throws InputError if one is missing
void RunCheckpoint::addFinished(const FrameFile& file, int parts, std::vector<std::filesystem::path>& outputs) const
{
    for (int part = 0; part < parts; ++part) {
        outputs.push_back(mOutputs.texture(file.frame, part));
        if (isFinished(outputs.back())) continue;
        refuseCheckpoint(
            mOutputs.checkpoint(),
            fmt::format("tells that {} was finished, but it is not there: put it back", outputs.back().string()));
    }
}

void RunCheckpoint::checkEnds(const Checkpoint& before, const FrameFile& last) const
{
    if (mParams.substep(before.position.steps) == 0) return;
    refuseCheckpoint(
        mOutputs.checkpoint(),
        fmt::format("has textures after frame {} done, the input ends with that frame now: give all frames",
                    last.frame));
}

void RunCheckpoint::restore(const Checkpoint& before, const LoadedFrame& frame, FlowTexture& texture,
                            FlowSequence& flow, std::vector<std::filesystem::path>& finished) const
{
    const RunPosition& position = before.position;
    flow.setSpacing(position.frameSpacing);
    if (mParams.framesDone(position.steps) >= std::uint64_t(mParams.leadInFrames()))
        addFinished(frame.velocity.file, mParams.substep(position.steps), finished);
    const std::vector<VdbFile> parts = readParts(before, frame);
    try {
        texture.restore(position.steps, position.interval / mParams.scatter.substeps, frame.flow.domain,
                        before.parts.empty() ? before.states : parts);
    } catch (const InputError& error) {
        refuseCheckpoint(mOutputs.checkpoint(), fmt::format("{}: copy it again", error.what()));
    }
    mReporter.say(fmt::format("{}: {} textures are done", mOutputs.checkpoint().string(), finished.size()));
}

/// Read the parts of a checkpoint that this rank needs.
std::vector<VdbFile> RunCheckpoint::readParts(const Checkpoint& before, const LoadedFrame& frame) const
{
    std::vector<VdbFile> states;
    for (const CheckpointPart& part : before.parts) {
        if (frame.partition && !frame.partition->textureBox(mExchange.rank()).hasOverlap(part.box)) continue;
        if (!isFinished(part.path)) {
            refuseCheckpoint(mOutputs.checkpoint(),
                             fmt::format("needs {}, which is not there: put it back", part.path.string()));
        }
        Checkpoint read = readCheckpoint(part.path, mParameters);
        if (read.position.steps != before.position.steps || read.states.empty())
            refuseCheckpoint(mOutputs.checkpoint(), fmt::format("does not belong to {}", part.path.string()));
        states.push_back(std::move(read.states.front()));
    }
    return states;
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

void RunCheckpoint::stepDone(const RunPosition& position, const LoadedFrame& frame)
{
    mUnsaved = {position, frame.textureTransform(), frame.partition};
    mSchedule.stepDone();
}

void RunCheckpoint::write(const FlowTexture& texture)
{
    const auto [position, transform, partition] = std::move(mUnsaved.value());
    mUnsaved.reset();
    const auto start = CheckpointSchedule::Clock::now();
    Checkpoint checkpoint{position, mInputs, {{}}};
    // A step depends on the frames at both ends of its interval and on none after them.
    const std::size_t lastStep = std::max(position.steps, std::uint64_t(1)) - 1;
    checkpoint.inputs.resize(std::min<std::size_t>(mParams.framesDone(lastStep) + 2, mInputs.size()));
    try {
        VdbFile& state = checkpoint.states.front();
        state.grids = texture.save();
        for (const auto& grid : state.grids)
            grid->setTransform(transform->copy());
        partition ? writePart(std::move(checkpoint), *partition) : writeWhole(checkpoint);
    } catch (const std::bad_alloc&) {
        throw InputError(fmt::format("{}: takes more than the {} of memory that may be used: raise `max_memory`, or "
                                     "give `checkpoint_every` 0 to do without",
                                     mOutputs.checkpoint().string(), memoryText(double(memoryLimit()))));
    } catch (const OutputError& error) {
        throw OutputError(fmt::format("{}; `checkpoint_every` 0 does without checkpoints", error.what()));
    }
    mSchedule.wrote(CheckpointSchedule::Clock::now() - start);
}

void RunCheckpoint::writeWhole(const Checkpoint& checkpoint) const
{
    writeCheckpoint(mOutputs.checkpoint(), checkpoint, mParameters);
    removeParts({}); // of a run by ranks that this one goes on from
}

/// Every rank writes its part, then rank 0 the file that lists them: until then the checkpoint before is valid.
void RunCheckpoint::writePart(Checkpoint checkpoint, const Partition& partition)
{
    const std::uint64_t steps = checkpoint.position.steps;
    for (int rank = 0; rank < partition.ranks(); ++rank)
        checkpoint.parts.push_back({mOutputs.checkpointPart(steps, rank), partition.textureBox(rank)});
    const std::filesystem::path mine = checkpoint.parts[std::size_t(mExchange.rank())].path;
    try {
        Checkpoint part = checkpoint;
        part.parts.clear();
        writeCheckpoint(mine, part, mParameters);
        mExchange.agree();
        checkpoint.states.clear();
        if (mExchange.isFirst()) writeCheckpoint(mOutputs.checkpoint(), checkpoint, mParameters);
        mExchange.agree();
    } catch (...) {
        std::error_code ignored;
        std::filesystem::remove(mine, ignored);
        throw;
    }
    if (mExchange.isFirst()) removeParts(steps);
}

/// Remove the parts of checkpoints. @param but steps whose parts stay
void RunCheckpoint::removeParts(std::optional<std::uint64_t> but) const
{
    for (const std::filesystem::path& part : mOutputs.checkpointParts(but))
        std::filesystem::remove(part);
}

void RunCheckpoint::remove() const
{
    if (!mExchange.isFirst()) return;
    std::error_code error;
    std::filesystem::remove(mOutputs.checkpoint(), error);
    if (!error) {
        removeParts({});
        return;
    }
    throw OutputError(fmt::format("{}: cannot be removed: {}", mOutputs.checkpoint().string(), error.message()));
}

} // namespace vdblic
