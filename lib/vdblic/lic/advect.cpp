#include "vdblic/lic/advect.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/stopwatch.h"
#include "vdblic/field/derived_grids.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/file_stamp.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/lic/checkpoint.h"
#include "vdblic/lic/flow_sequence.h"
#include "vdblic/lic/flow_texture.h"
#include "vdblic/lic/frame_writer.h"
#include "vdblic/lic/noise_file.h"
#include "vdblic/lic/run_report.h"

namespace vdblic {
namespace {

openvdb::FloatGrid::Ptr magnitudeGrid(const FlowFrame& frame)
{
    const LeafValues<float> magnitude(*frame.domain, 0.0f);
    const openvdb::Mat3s toWorld(frame.toWorldPerSecond);
    tbb::parallel_for(std::size_t(0), frame.domain->leafCount(), [&](std::size_t leaf) {
        const auto values = frame.velocities->getConstAccessor();
        for (auto voxel = frame.domain->mask(leaf).beginOn(); voxel; ++voxel) {
            const openvdb::Coord at = frame.domain->origin(leaf) + Domain::Leaf::offsetToLocalCoord(voxel.pos());
            magnitude[leaf][voxel.pos()] = (toWorld * values.getValue(at)).length();
        }
    });
    return openvdb::FloatGrid::create(magnitude.tree());
}

/// The whole run: state that outlives a frame.
class Advection {
  public:
    Advection(const AdvectParams& params, std::istream& lines, Reporter& reporter)
        : mParams(params), mReporter(reporter), mPattern(params.output),
          mCheckpointPath(mPattern.companion("checkpoint")), mParameters(parameterTexts(params)),
          mTexture(params.scatter, params.feedback,
                   NoiseField(params.seed, params.noise.empty() ? nullptr : readNoise(params.noise)), params.steady),
          mFlow({params.input, params.velocity, params.frameSpacing, params.domain}, lines, reporter),
          mWriter(reporter, mFlow.total()), mSchedule(params.checkpointEvery)
    {
        if (mFlow.total() > 0) checkOutputPattern(mPattern, mFlow.total());
        if (mParams.json.empty()) return;
        checkNoFrame(mParams.json, mPattern);
        checkDistinct(mParams.json, mCheckpointPath);
        AtomicFile{mParams.json}; // can it be written? Not only after hours
    }

    void run()
    {
        std::optional<Checkpoint> before = findCheckpoint();
        std::vector<std::filesystem::path> finished;
        if (before) finished = passOver(*before);
        std::optional<LoadedFrame> current = nextFrame();
        mReporter.checkStop(); // it may have ended standard input
        if (!current) {
            mReporter.warn("no frames on standard input; nothing was computed");
            return;
        }
        checkOutput(*current);
        std::optional<LoadedFrame> next = nextFrame();
        FrameInterval interval{};
        if (before) {
            interval = {before->interval, "as before"};
            restore(std::move(*before), *current);
            for (const std::filesystem::path& output : finished)
                mWriter.pass(output);
        } else {
            removeCheckpoint();
            mTime = current->velocity.time.value_or(0);
            interval = mFlow.intervalAfter(*current, next ? &*next : nullptr);
        }
        mFlow.describe(*current, interval);
        Stopwatch watch;
        while (mTexture.steps() < preroll()) {
            advance(*current, *current, interval.seconds);
            keepState(*current);
        }

        while (current) {
            if (next) interval = mFlow.intervalAfter(*current, &*next);
            // The last frame's flow is taken to go on as it is.
            write(*current, advance(*current, next ? *next : *current, interval.seconds), interval.seconds);
            mTime += interval.seconds;
            current = std::move(next);
            if (!current) break;
            keepState(*current);
            checkOutput(*current);
            next = nextFrame();
        }
        mWriter.finish();
        removeCheckpoint();
        report(watch.lap());
    }

    /// After an error or a request to stop: finish what is being written, and leave a checkpoint of what is finished.
    void abandon() noexcept
    {
        try {
            mWriter.finish();
            if (!mSchedule.enabled() || !mUnsaved || mWriter.done() != framesDone()) return;
            writeState();
            mReporter.say(fmt::format("{}: to go on from there, run again with --resume", mCheckpointPath.string()));
        } catch (...) { // the first error is the one to report
        }
    }

  private:
    /// What is written must not replace what is read.
    void checkOutput(const LoadedFrame& frame) const
    {
        const std::int64_t number = frame.velocity.file.frame;
        std::vector<std::filesystem::path> inputs = {frame.velocity.file.path};
        for (const std::string& reference : {mParams.noise, mParams.domain.mask}) {
            if (reference.empty()) continue;
            inputs.push_back(FramePattern(parseGridReference(reference).path.string()).path(number));
        }
        for (const std::filesystem::path& input : inputs) {
            checkNotInput(mPattern.path(number), input);
            checkNotInput(mCheckpointPath, input);
            if (!mParams.json.empty()) checkNotInput(mParams.json, input);
        }
    }

    [[nodiscard]] std::uint64_t preroll() const { return std::uint64_t(mParams.prerollSteps()); }
    /// Frames whose step is made.
    [[nodiscard]] std::size_t framesDone() const
    {
        return std::size_t(std::max(mTexture.steps(), preroll()) - preroll());
    }

    [[nodiscard]] std::optional<Checkpoint> findCheckpoint() const
    {
        if (!mParams.resume) return std::nullopt;
        if (isFinished(mCheckpointPath)) return readCheckpoint(mCheckpointPath, mParameters);
        mReporter.say(fmt::format("no {}: starting from the beginning", mCheckpointPath.string()));
        return std::nullopt;
    }

    void removeCheckpoint() const
    {
        std::error_code error;
        const bool removed = std::filesystem::remove(mCheckpointPath, error);
        if (error) {
            throw OutputError(fmt::format("{}: cannot be removed: {}", mCheckpointPath.string(), error.message()));
        }
        if (removed && mTexture.steps() == 0) {
            mReporter.warn(
                fmt::format("{}: removed; with --resume the run would have gone on from it", mCheckpointPath.string()));
        }
    }

    /// Pass over the frames that an interrupted run finished. @return their outputs
    [[nodiscard]] std::vector<std::filesystem::path> passOver(const Checkpoint& before)
    {
        mExpected = before.inputs;
        const std::uint64_t frames = std::max(before.steps, preroll()) - preroll();
        std::vector<std::filesystem::path> outputs;
        for (std::uint64_t i = 0; i < frames; ++i) {
            const std::optional<FrameFile> file = mFlow.skip();
            if (!file) {
                mReporter.checkStop();
                refuseCheckpoint(mCheckpointPath, fmt::format("has {} frames done, the input has only {} now: give all "
                                                              "of them",
                                                              frames, i));
            }
            noteInput(file->path, mFlow.stampOf(*file));
            outputs.push_back(mPattern.path(file->frame));
            if (isFinished(outputs.back())) continue;
            refuseCheckpoint(
                mCheckpointPath,
                fmt::format("tells that {} was finished, but it is not there: put it back", outputs.back().string()));
        }
        return outputs;
    }

    /// Go on where the interrupted run was. @param frame that the next step starts from
    void restore(Checkpoint before, const LoadedFrame& frame)
    {
        mTime = before.time;
        mFlow.setSpacing(before.frameSpacing);
        try {
            mTexture.restore(before.steps, before.interval, frame.flow.domain, before.state);
        } catch (const InputError& error) {
            refuseCheckpoint(mCheckpointPath, fmt::format("{}: copy it again", error.what()));
        }
        mReporter.say(fmt::format("{}: {} frames are done", mCheckpointPath.string(), framesDone()));
    }

    std::optional<LoadedFrame> nextFrame()
    {
        std::optional<LoadedFrame> frame = mFlow.next();
        if (frame) noteInput(frame->velocity.file.path, frame->stamp);
        return frame;
    }

    /// Note what a frame was like, and that it is what the interrupted run read.
    void noteInput(const std::filesystem::path& path, const std::string& stamp)
    {
        const std::size_t number = mInputs.size();
        mInputs.push_back(stamp);
        if (number >= mExpected.size() || mExpected[number] == stamp) return;
        throw InputError(
            fmt::format("{}: differs from what the interrupted run read: {}; put that back, or delete {} to "
                        "start from the beginning",
                        path.string(), stampDifference(mExpected[number], stamp), mCheckpointPath.string()));
    }

    /// A step is made. @param frame that the next one starts from
    void keepState(const LoadedFrame& frame)
    {
        mTransform = frame.velocity.values->transform().copy();
        mUnsaved = true;
        mSchedule.stepDone();
        if (!mSchedule.isDue()) return;
        mWriter.finish(); // a checkpoint tells of nothing that is not on disk
        writeState();
    }

    void writeState()
    {
        mUnsaved = false;
        const auto start = CheckpointSchedule::Clock::now();
        Checkpoint checkpoint{mTexture.steps(), mInterval, mTime, mFlow.spacing(), mInputs, {}};
        // A step depends on both its frames, and no more than these.
        const std::size_t frames = std::max<std::size_t>(framesDone(), 1) + 1;
        checkpoint.inputs.resize(std::min(frames, mInputs.size()));
        try {
            checkpoint.state.grids = mTexture.save();
            for (const auto& grid : checkpoint.state.grids)
                grid->setTransform(mTransform->copy());
            writeCheckpoint(mCheckpointPath, checkpoint, mParameters);
        } catch (const std::bad_alloc&) {
            throw InputError(
                fmt::format("{}: takes more than the {} of memory that may be used: raise --max-memory, or "
                            "give --checkpoint-every 0 to do without",
                            mCheckpointPath.string(), memoryText(double(memoryLimit()))));
        } catch (const OutputError& error) {
            throw OutputError(fmt::format("{}; --checkpoint-every 0 does without checkpoints", error.what()));
        }
        mSchedule.wrote(CheckpointSchedule::Clock::now() - start);
    }

    FlowTextureStep advance(LoadedFrame& start, LoadedFrame& end, double seconds)
    {
        mReporter.checkStop();
        mUnsaved = false; // a step that fails midway leaves no state to go on from
        mInterval = seconds;
        start.flow.toWorldPerSecond = start.velocity.toWorldPerSecond(seconds);
        return mTexture.advance({start.flow, end.flow, start.velocity.toVoxelsPerStep(seconds),
                                 end.velocity.toVoxelsPerStep(seconds), seconds});
    }

    void write(const LoadedFrame& frame, const FlowTextureStep& step, double seconds)
    {
        checkFlow(frame, seconds);
        const auto texture = openvdb::FloatGrid::create(step.texture.tree());
        texture->setName(mParams.textureName);
        const auto magnitude = magnitudeGrid(frame.flow);
        magnitude->setName("magnitude");
        for (const auto& grid : {texture, magnitude}) {
            grid->setTransform(frame.velocity.values->transform().copy());
            grid->setGridClass(openvdb::GRID_FOG_VOLUME);
        }
        openvdb::GridCPtrVec grids = {texture, magnitude};
        for (auto& grid :
             derivedGrids(mParams.derived, *frame.flow.domain, *frame.velocity.values, frame.flow.toWorldPerSecond))
            grids.push_back(std::move(grid));
        grids.insert(grids.end(), frame.velocity.carried.begin(), frame.velocity.carried.end());
        openvdb::MetaMap metadata = parameterMetadata(mParams);
        if (!frame.velocity.sourceCreator.empty()) {
            metadata.insertMeta("source_creator", openvdb::StringMetadata(frame.velocity.sourceCreator));
        }
        metadata.insertMeta("frame", openvdb::Int64Metadata(frame.velocity.file.frame));
        metadata.insertMeta("time", openvdb::DoubleMetadata(mTime));
        metadata.insertMeta("dt", openvdb::DoubleMetadata(seconds));
        mReport.frames.push_back(
            {frame.velocity.file.frame, frame.flow.domain->voxelCount(), step.stats, frame.seconds, step.times});
        mReporter.detail(frameLine(mReport.frames.back()));
        mWriter.write(mPattern.path(frame.velocity.file.frame), std::move(grids), std::move(metadata));
    }

    /// @param seconds from the first step to the last output
    void report(double seconds)
    {
        mReport.seconds = seconds;
        for (std::size_t i = 0; i < mReport.frames.size(); ++i)
            mReport.frames[i].write = mWriter.seconds()[i];
        for (const std::string& line : runLines(mReport))
            mReporter.detail(line);
        if (!mParams.json.empty()) writeTextFile(mParams.json, toJson(mReport));
    }

    /// What is odd about a frame, though it can be computed.
    void checkFlow(const LoadedFrame& frame, double seconds)
    {
        const std::int64_t number = frame.velocity.file.frame;
        if (frame.flow.domain->voxelCount() == 0) {
            mReporter.warn(fmt::format("frame {}: {}: no active voxels; its texture is empty", number,
                                       frame.velocity.file.path.string()));
            return;
        }
        const double largest = frame.velocity.largestDisplacement(seconds);
        if (largest <= kLargeDisplacement || mWarnedOfDisplacement) return;
        mWarnedOfDisplacement = true;
        mReporter.warn(
            fmt::format("frame {}: the flow moves up to {:.1f} voxels a step; over more than {} it is hardly "
                        "linear in time between frames: check unit and frame spacing, or use frames closer in time",
                        number, largest, kLargeDisplacement));
    }

    const AdvectParams& mParams;
    Reporter& mReporter;
    FramePattern mPattern;
    std::filesystem::path mCheckpointPath;
    ParameterTexts mParameters;
    FlowTexture mTexture;
    FlowSequence mFlow;
    FrameWriter mWriter;
    CheckpointSchedule mSchedule;
    RunReport mReport;
    double mTime = 0, mInterval = 0;
    std::vector<std::string> mInputs, mExpected; // stamps, of the frames read and of those an interrupted run read
    openvdb::math::Transform::Ptr mTransform;
    bool mUnsaved = false; // there is a state to go on from that no checkpoint has
    bool mWarnedOfDisplacement = false;
};

} // namespace

void advectSequence(const AdvectParams& params, std::istream& lines, Reporter& reporter)
{
    params.validate();
    Advection advection(params, lines, reporter);
    try {
        advection.run();
    } catch (...) {
        advection.abandon();
        throw;
    }
}

} // namespace vdblic
