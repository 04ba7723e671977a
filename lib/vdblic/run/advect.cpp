#include "vdblic/run/advect.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/stopwatch.h"
#include "vdblic/flow/flow_sequence.h"
#include "vdblic/flow/frame_between.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/lic/flow_texture.h"
#include "vdblic/noise/noise_field.h"
#include "vdblic/noise/noise_file.h"
#include "vdblic/run/frame_writer.h"
#include "vdblic/run/lead_in.h"
#include "vdblic/run/memory_estimate.h"
#include "vdblic/run/run_checkpoint.h"
#include "vdblic/run/run_outputs.h"
#include "vdblic/run/run_report.h"
#include "vdblic/run/shared_run.h"
#include "vdblic/run/texture_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <istream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

/// Ranks that write files at the same time. Carried grids are at rank 0 only, which then writes all.
constexpr int kMostWriters = 8;

/// A run over the frames of a sequence.
class Advection {
  public:
    Advection(const AdvectParams& params, std::istream& lines, Reporter& reporter, Exchange& exchange)
        : mParams(params), mReporter(reporter), mExchange(exchange), mShared(params, exchange), mOutputs(params),
          mCheckpoint(params, mOutputs, reporter, exchange),
          mTexture(params.scatter, params.feedback,
                   NoiseField(params.seed, params.noise.empty() ? nullptr : readNoise(params.noise)), params.steady),
          mFlow({params.input, params.velocity, params.frameSpacing, params.domain}, lines, reporter, exchange),
          mWriter(reporter, exchange,
                  params.textures(mFlow.total() - std::min(mFlow.total(), std::size_t(params.leadInFrames()))),
                  params.format.compression, params.velocity.carry.empty() ? kMostWriters : 1)
    {
        mOutputs.check(mWriter.total());
    }

    void run()
    {
        std::optional<Checkpoint> before = mCheckpoint.find();
        std::vector<std::filesystem::path> finished;
        if (before) finished = mCheckpoint.passOver(*before, mFlow);
        std::optional<LoadedFrame> current = nextFrame();
        mReporter.checkStop(); // a stop may be what ended standard input
        if (!current) {
            throw InputError("no frame to compute: standard input named none");
        }
        mOutputs.startAt(current->velocity.file.frame);
        mOutputs.checkInputs(current->velocity.file);
        std::optional<LoadedFrame> next = nextFrame();
        FrameInterval interval{};
        if (before) {
            if (!next) mCheckpoint.checkEnds(*before, current->velocity.file);
            interval = goOn(*before, *current, std::move(finished));
            before.reset(); // frees the memory of its state
        } else {
            interval = begin(*current, next);
        }
        mFlow.describe(*current, interval, mShared.largestDisplacement(*current, interval.seconds));
        checkMemoryFor(current->flow);

        Stopwatch watch;
        while (mTexture.steps() < mParams.prerollSteps()) {
            mShared.surround(*current, *current, interval.seconds, mTexture);
            advance(*current, *current, interval.seconds);
            stepDone(*current);
            saveIfDue();
        }
        while (next) {
            interval = mFlow.intervalAfter(*current, &*next);
            compute(*current, *next, interval.seconds);
            current = std::move(next);
            mOutputs.checkInputs(current->velocity.file);
            next = nextFrame();
        }
        mWriter.finish();
        if (mParams.keepCheckpoint && mCheckpoint.isUnsaved()) mCheckpoint.write(mTexture);
        writeLast(*current, interval);
        mWriter.finish();
        if (!mParams.keepCheckpoint) mCheckpoint.remove();
        report(watch.lap());
    }

    /// After an error or a request to stop: finish what is being written, and leave a checkpoint of what is finished.
    void abandon() noexcept
    {
        try {
            mWriter.finishWriting();
            const bool isWritten = mWriter.done() == mParams.texturesDone(mTexture.steps());
            std::array<double, 2> steps = {double(mTexture.steps()), -double(mTexture.steps())};
            mExchange.max(steps); // a rank may have failed in the middle of a step
            if (mExchange.any(!mCheckpoint.isUnsaved() || !isWritten || steps[0] != -steps[1])) return;
            mCheckpoint.write(mTexture);
            mReporter.say(
                fmt::format("{}: to go on from there, run again with `resume`", mOutputs.checkpoint().string()));
        } catch (...) { // the first error is the one to report
            mExchange.fail(std::current_exception());
        }
    }

  private:
    /// Start from the first frame. @return the interval after it
    FrameInterval begin(const LoadedFrame& first, const std::optional<LoadedFrame>& next)
    {
        mCheckpoint.remove();
        const std::optional<LoadedFrame>& end = next ? next : mAfter;
        const FrameInterval interval = mFlow.intervalAfter(first, end ? &*end : nullptr);
        // Added up, as by a run over all frames.
        for (int i = 0; i < mParams.framesBefore; ++i)
            mTime += interval.seconds;
        mTime = first.velocity.time.value_or(mTime);
        return interval;
    }

    /// Go on where an interrupted run was. @param frame that the next step starts from @param finished outputs of that
    /// run
    FrameInterval goOn(const Checkpoint& before, const LoadedFrame& frame, std::vector<std::filesystem::path> finished)
    {
        mTime = before.position.time;
        mCheckpoint.restore(before, frame, mTexture, mFlow, finished);
        for (const std::filesystem::path& output : finished)
            mWriter.pass(output);
        return {before.position.interval, "as before"};
    }

    /// Tell how much memory the run takes; refuse a run that takes too much now, not after minutes.
    void checkMemoryFor(const FlowFrame& first) const
    {
        const double bytes = advectBytes(mParams, first);
        const std::string voxels = fmt::format("{} texture voxels", first.domain->voxelCount());
        const std::string each = mExchange.isAlone() ? "" : fmt::format(" each for {} ranks", mExchange.size());
        const std::string text = fmt::format("{}: about {} of memory{}", voxels, memoryText(bytes), each);
        first.refinement.isNone() ? mReporter.detail(text) : mReporter.say(text);
        constexpr double kLeast = 0.75; // of the estimate
        checkMemory(kLeast * bytes, voxels, "lower `refine`, or cut the domain with `box` or `mask`");
    }

    std::optional<LoadedFrame> nextFrame()
    {
        std::optional<LoadedFrame> frame = mFlow.next();
        mShared.checkSame(frame ? frame->stamp : "");
        if (frame) {
            mCheckpoint.noteInput(frame->velocity.file.path, frame->stamp);
        } else {
            mAfter = mFlow.after();
            mShared.checkSame(mAfter ? mAfter->stamp : "");
        }
        return frame;
    }

    /// The textures of a frame and of the substeps between it and the next. @param seconds between the frames
    void compute(LoadedFrame& frame, LoadedFrame& next, double seconds)
    {
        balance(frame);
        mShared.surround(frame, next, seconds, mTexture);
        const int parts = mParams.scatter.substeps;
        const auto at = [&](int part) {
            return part == 0 ? frame : part == parts ? next : frameBetween(frame, next, double(part) / parts);
        };
        int part = mParams.substep(mTexture.steps());
        for (LoadedFrame start = at(part); part < parts; ++part) {
            LoadedFrame end = at(part + 1);
            const bool isWritten = mTexture.steps() >= mParams.warmUpSteps();
            FlowTextureStep step = advance(start, end, seconds);
            const StepTime time{mTime + part * seconds / parts, seconds, part};
            if (part + 1 == parts) mTime += seconds;
            // Before the texture is written: if its path cannot be reported, a checkpoint holds this step all the same.
            stepDone(end);
            if (isWritten) write(start, std::move(step), time);
            saveIfDue();
            start = std::move(end);
        }
    }

    /// Give the ranks about equal shares of a frame, before a step starts from it.
    void balance(LoadedFrame& frame)
    {
        const std::optional<std::string> how = mShared.balance(frame, mTexture);
        if (!how) return;
        mFlow.cutAs(frame.partition);
        mReporter.detail(fmt::format("frame {}: {}", frame.velocity.file.frame, *how));
    }

    /// The texture of the last frame. Without a frame after it the flow is taken to stay as it is.
    void writeLast(LoadedFrame& frame, FrameInterval interval)
    {
        LoadedFrame end = frame;
        if (mAfter) {
            const int parts = mParams.scatter.substeps;
            interval = mFlow.intervalAfter(frame, &*mAfter);
            mShared.surround(frame, *mAfter, interval.seconds, mTexture);
            end = parts == 1 ? std::move(*mAfter) : frameBetween(frame, *mAfter, 1.0 / parts);
        } else {
            mShared.surround(frame, end, interval.seconds, mTexture);
        }
        write(frame, advance(frame, end, interval.seconds), {mTime, interval.seconds});
    }

    /// @param interval seconds between the frames that the step is a part of
    FlowTextureStep advance(LoadedFrame& start, const LoadedFrame& end, double interval)
    {
        if (mExchange.any(mReporter.stopRequested())) throw Stopped{};
        mCheckpoint.stepBegins();
        mInterval = interval;
        start.flow.toWorldPerSecond = start.velocity.toWorldPerSecond(interval);
        const double part = 1.0 / mParams.scatter.substeps; // of the interval
        const std::optional<HaloExchange> halo = mShared.haloOf(start);
        return mTexture.advance({start.flow, end.flow, start.velocity.toVoxelsPerStep(interval) * part,
                                 end.velocity.toVoxelsPerStep(interval) * part, interval / mParams.scatter.substeps,
                                 halo ? &*halo : nullptr});
    }

    /// @param frame that the next step starts from
    void stepDone(const LoadedFrame& frame)
    {
        mCheckpoint.stepDone({mTexture.steps(), mInterval, mTime, mFlow.spacing()}, frame);
    }

    void saveIfDue()
    {
        if (!mExchange.any(mExchange.isFirst() && mCheckpoint.isDue())) return;
        mWriter.finish(); // a checkpoint covers only outputs that are on disk
        mCheckpoint.write(mTexture);
    }

    /// When a step begins.
    struct StepTime {
        double seconds;  // of its texture
        double interval; // seconds between the frames that the step is a part of
        int part = 0;    // number of the substep after the frame
    };

    void write(const LoadedFrame& frame, FlowTextureStep step, const StepTime& time)
    {
        const auto [textureTime, interval, part] = time;
        if (part == 0) warnOfOddFlow(frame, interval);
        const std::int64_t number = mOutputs.number(frame.velocity.file.frame, part);
        const double seconds = interval / mParams.scatter.substeps;
        if (!mParams.steady) {
            step.texture =
                finished(frame.flow, frame.velocity.toVoxelsPerStep(interval), std::move(step.texture), mParams.finish);
        }
        TextureFile file = makeTextureFile(mParams, frame, step.texture.tree(), *frame.textureTransform(),
                                           {number, frame.sourceFrame, textureTime, seconds});
        step.texture = {}; // its grid is freed as soon as its leaves are stored
        mReport.frames.push_back({number, frame.flow.domain->voxelCount(), step.stats, frame.seconds, step.times});
        mReporter.detail(frameLine(mReport.frames.back()));
        Stopwatch watch;
        std::vector<OwnLeaves> own = mShared.store(frame, file, mWriter.isMineNext());
        mReport.frames.back().write = watch.lap();
        mWriter.write(mOutputs.texture(frame.velocity.file.frame, part), std::move(file), std::move(own));
    }

    /// Warn of what is likely wrong with a frame, though its texture can be computed.
    void warnOfOddFlow(const LoadedFrame& frame, double seconds)
    {
        const std::int64_t number = frame.velocity.file.frame;
        if (frame.flow.domain->voxelCount() == 0) {
            const bool isCut = mExchange.any(frame.velocity.values->activeVoxelCount() > 0);
            mReporter.warn(
                fmt::format("frame {}: {}: {}; its texture is empty", number, frame.velocity.file.path.string(),
                            isCut ? "no active voxel lies inside `box`, `world_box` and `mask`" : "no active voxels"));
            return;
        }
        const double largest = mShared.largestDisplacement(frame, seconds);
        constexpr double kRest = 1e-3; // voxels a step
        if (largest < kRest && !mWarnedOfRest) {
            mWarnedOfRest = true;
            mReporter.warn(fmt::format("frame {}: {}: grid {} moves nothing by more than {:.3g} voxels a step, and a "
                                       "texture without motion is noise: check unit and frame spacing",
                                       number, frame.velocity.file.path.string(), frame.velocity.gridName, largest));
        }
        // A texture of its frame alone does not depend on time.
        if (mParams.steady || largest <= kLargeDisplacement || mWarnedOfDisplacement) return;
        mWarnedOfDisplacement = true;
        mReporter.warn(
            fmt::format("frame {}: the flow moves up to {:.1f} voxels a step; over more than {} it is hardly "
                        "linear in time between frames: check unit and frame spacing, or use frames closer in time",
                        number, largest, kLargeDisplacement));
    }

    /// @param seconds from the first step to the last output
    void report(double seconds)
    {
        std::array<std::uint64_t, 2> sent = {mExchange.sent() - mWriter.sent(), mWriter.sent()};
        mExchange.sum(sent);
        if (!mExchange.isFirst()) return;
        if (!mExchange.isAlone()) {
            mReporter.detail(fmt::format("{} ranks exchanged {:.1f} MB in {} steps, and {:.1f} MB of outputs",
                                         mExchange.size(), double(sent[0]) / 1e6, mTexture.steps(),
                                         double(sent[1]) / 1e6));
        }
        mReport.seconds = seconds;
        for (std::size_t i = 0; i < mReport.frames.size(); ++i)
            mReport.frames[i].write += mWriter.seconds()[i];
        for (const std::string& line : runLines(mReport))
            mReporter.detail(line);
        if (!mParams.json.empty()) (void)writeReport(mParams.json, toJson(mReport));
    }

    const AdvectParams& mParams;
    Reporter& mReporter;
    Exchange& mExchange;
    SharedRun mShared;
    RunOutputs mOutputs;
    RunCheckpoint mCheckpoint;
    FlowTexture mTexture;
    FlowSequence mFlow;
    FrameWriter mWriter;
    RunReport mReport;
    std::optional<LoadedFrame> mAfter; // on disk after the last frame, once that is reached
    double mTime = 0;                  // of the frame that the next step starts from or after
    double mInterval = 0;              // between the frames of the last step
    bool mWarnedOfDisplacement = false, mWarnedOfRest = false;
};

std::string textOf(std::istream& lines)
{
    return {std::istreambuf_iterator<char>(lines), std::istreambuf_iterator<char>()};
}

} // namespace

void advectSequence(const AdvectParams& params, std::istream& lines, Reporter& reporter)
{
    OneProcess alone;
    advectSequence(params, lines, reporter, alone);
}

void advectSequence(const AdvectParams& params, std::istream& lines, Reporter& reporter, Exchange& exchange)
{
    AdvectParams whole;
    std::istringstream text;
    std::optional<Advection> advection;
    bool isRunning = false; // at every rank or at none
    try {
        params.validate();
        const bool isShared = params.input.pattern == "-" && !exchange.isAlone();
        if (isShared) text.str(exchange.broadcast(exchange.isFirst() ? textOf(lines) : ""));
        whole = withLeadIn(params, reporter);
        advection.emplace(whole, isShared ? text : lines, reporter, exchange);
        exchange.agree();
        isRunning = true;
        advection->run();
        exchange.agree(); // also that rank 0 could write its report
    } catch (...) {
        exchange.fail(std::current_exception());
        if (isRunning) advection->abandon();
        throw;
    }
}

} // namespace vdblic
