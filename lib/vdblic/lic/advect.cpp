#include "vdblic/lic/advect.h"

#include "vdblic/core/stopwatch.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/lic/flow_sequence.h"
#include "vdblic/lic/flow_texture.h"
#include "vdblic/lic/frame_writer.h"
#include "vdblic/lic/noise_field.h"
#include "vdblic/lic/noise_file.h"
#include "vdblic/lic/run_checkpoint.h"
#include "vdblic/lic/run_outputs.h"
#include "vdblic/lic/run_report.h"
#include "vdblic/lic/texture_file.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

/// A run over the frames of a sequence.
class Advection {
  public:
    Advection(const AdvectParams& params, std::istream& lines, Reporter& reporter)
        : mParams(params), mReporter(reporter), mOutputs(params), mCheckpoint(params, mOutputs, reporter),
          mTexture(params.scatter, params.feedback,
                   NoiseField(params.seed, params.noise.empty() ? nullptr : readNoise(params.noise)), params.steady),
          mFlow({params.input, params.velocity, params.frameSpacing, params.domain}, lines, reporter),
          mWriter(reporter, mFlow.total(), params.format.compression)
    {
        mOutputs.check(mFlow.total());
    }

    void run()
    {
        std::optional<Checkpoint> before = mCheckpoint.find();
        std::vector<std::filesystem::path> finished;
        if (before) finished = mCheckpoint.passOver(*before, mFlow);
        std::optional<LoadedFrame> current = nextFrame();
        mReporter.checkStop(); // a stop may be what ended standard input
        if (!current) {
            mReporter.warn("no frames on standard input; nothing was computed");
            return;
        }
        mOutputs.checkInputs(current->velocity.file);
        std::optional<LoadedFrame> next = nextFrame();
        FrameInterval interval{};
        if (before) {
            interval = goOn(*before, *current, finished);
            before.reset(); // frees the memory of its state
        } else {
            interval = begin(*current, next);
        }
        mFlow.describe(*current, interval);

        Stopwatch watch;
        while (mTexture.steps() < std::uint64_t(mParams.prerollSteps())) {
            advance(*current, *current, interval.seconds);
            saveIfDue(*current);
        }
        while (current) {
            if (next) interval = mFlow.intervalAfter(*current, &*next);
            // After the last frame the flow is taken to stay as it is.
            const FlowTextureStep step = advance(*current, next ? *next : *current, interval.seconds);
            write(*current, step, interval.seconds);
            mTime += interval.seconds;
            current = std::move(next);
            if (!current) break;
            saveIfDue(*current);
            mOutputs.checkInputs(current->velocity.file);
            next = nextFrame();
        }
        mWriter.finish();
        mCheckpoint.remove();
        report(watch.lap());
    }

    /// After an error or a request to stop: finish what is being written, and leave a checkpoint of what is finished.
    void abandon() noexcept
    {
        try {
            mWriter.finish();
            if (!mCheckpoint.isUnsaved() || mWriter.done() != mParams.framesDone(mTexture.steps())) return;
            mCheckpoint.write(mTexture);
            mReporter.say(
                fmt::format("{}: to go on from there, run again with `resume`", mOutputs.checkpoint().string()));
        } catch (...) { // the first error is the one to report
        }
    }

  private:
    /// Start from the first frame. @return the interval after it
    FrameInterval begin(const LoadedFrame& first, const std::optional<LoadedFrame>& next)
    {
        mCheckpoint.discard();
        mTime = first.velocity.time.value_or(0);
        return mFlow.intervalAfter(first, next ? &*next : nullptr);
    }

    /// Go on where an interrupted run was. @param frame that the next step starts from @param finished outputs of that
    /// run
    FrameInterval goOn(const Checkpoint& before, const LoadedFrame& frame,
                       const std::vector<std::filesystem::path>& finished)
    {
        mTime = before.position.time;
        mCheckpoint.restore(before, frame, mTexture, mFlow);
        for (const std::filesystem::path& output : finished)
            mWriter.pass(output);
        return {before.position.interval, "as before"};
    }

    std::optional<LoadedFrame> nextFrame()
    {
        std::optional<LoadedFrame> frame = mFlow.next();
        if (frame) mCheckpoint.noteInput(frame->velocity.file.path, frame->stamp);
        return frame;
    }

    FlowTextureStep advance(LoadedFrame& start, const LoadedFrame& end, double seconds)
    {
        mReporter.checkStop();
        mCheckpoint.stepBegins();
        mInterval = seconds;
        start.flow.toWorldPerSecond = start.velocity.toWorldPerSecond(seconds);
        return mTexture.advance({start.flow, end.flow, start.velocity.toVoxelsPerStep(seconds),
                                 end.velocity.toVoxelsPerStep(seconds), seconds});
    }

    /// @param frame that the next step starts from
    void saveIfDue(const LoadedFrame& frame)
    {
        mCheckpoint.stepDone({mTexture.steps(), mInterval, mTime, mFlow.spacing()}, frame);
        if (!mCheckpoint.isDue()) return;
        mWriter.finish(); // a checkpoint covers only outputs that are on disk
        mCheckpoint.write(mTexture);
    }

    void write(const LoadedFrame& frame, const FlowTextureStep& step, double seconds)
    {
        warnOfOddFlow(frame, seconds);
        const std::int64_t number = frame.velocity.file.frame;
        TextureFile file =
            makeTextureFile(mParams, frame, step.texture.tree(), *frame.textureTransform(), {number, mTime, seconds});
        mReport.frames.push_back({number, frame.flow.domain->voxelCount(), step.stats, frame.seconds, step.times});
        mReporter.detail(frameLine(mReport.frames.back()));
        mWriter.write(mOutputs.texture(number), std::move(file.grids), std::move(file.metadata));
    }

    /// Warn of what is likely wrong with a frame, though its texture can be computed.
    void warnOfOddFlow(const LoadedFrame& frame, double seconds)
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

    const AdvectParams& mParams;
    Reporter& mReporter;
    RunOutputs mOutputs;
    RunCheckpoint mCheckpoint;
    FlowTexture mTexture;
    FlowSequence mFlow;
    FrameWriter mWriter;
    RunReport mReport;
    double mTime = 0;     // of the frame that the next step starts from
    double mInterval = 0; // of the last step
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
