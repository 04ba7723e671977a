#include "vdblic/run/advect.h"

#include "vdblic/core/exchange.h"
#include "vdblic/core/stopwatch.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/output_lock.h"
#include "vdblic/run/advect_plan.h"
#include "vdblic/run/frame_writer.h"
#include "vdblic/run/run_checkpoint.h"
#include "vdblic/run/run_outputs.h"
#include "vdblic/run/run_report.h"
#include "vdblic/run/texture_file.h"
#include "vdblic/run/texture_run.h"

#include <fmt/format.h>

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

/// The most ranks that write files at the same time. Carried grids are at rank 0 only, which then writes all files.
constexpr int kMostWriters = 8;

/// A run over the frames of a sequence, from files to files.
class Advection : private RunObserver {
  public:
    Advection(const AdvectPlan& plan, std::istream& lines, Reporter& reporter, Exchange& exchange)
        : mPlan(plan), mReporter(reporter), mExchange(exchange), mOutputs(plan),
          mCheckpoint(plan, mOutputs, reporter, exchange),
          mRun(plan, openSequence(plan.input, lines, mTotal), reporter, exchange, *this),
          mWriter(reporter, exchange, plan.textures(mTotal), plan.params.format.compression,
                  plan.params.flow.velocity.carry.empty() ? kMostWriters : 1)
    {
        mOutputs.check(mWriter.total());
        if (exchange.isFirst()) mLock.emplace(mOutputs.lock(), plan.params.output);
    }

    void run()
    {
        for (TextureFrame& texture : mRun)
            write(std::move(texture));
        mWriter.finish();
        if (!mPlan.params.keepCheckpoint) mCheckpoint.remove();
        report(mWatch.lap());
    }

    /// After an error or a request to stop: finish open files, and write a checkpoint of the finished textures.
    void abandon() noexcept
    {
        try {
            mWriter.finishWriting();
            const std::uint64_t made = mRun.steps();
            const bool isWritten = mWriter.done() == mPlan.texturesDone(made);
            std::array<double, 2> steps = {double(made), -double(made)};
            mExchange.max(steps); // a rank may have failed in the middle of a step
            if (mExchange.any(!mCheckpoint.isUnsaved() || !isWritten || steps[0] != -steps[1])) return;
            mCheckpoint.write(mRun.texture());
            mReporter.say(
                fmt::format("{}: to go on from there, run again with `resume`", mOutputs.checkpoint().string()));
        } catch (...) { // the first error is the one to report
            mExchange.fail(std::current_exception());
        }
    }

  private:
    /// Start with the first frame, or at the position of an interrupted run.
    std::optional<RunPosition> begins(VelocitySequence& flow) override
    {
        mResumed = mCheckpoint.find();
        if (!mResumed) return std::nullopt;
        mFinished = mCheckpoint.passOver(*mResumed, flow);
        return mResumed->position;
    }

    void opened(const VelocityFrame& first, bool isOnly, FlowTexture& texture) override
    {
        if (!mResumed) return mCheckpoint.remove();
        if (isOnly) mCheckpoint.checkEnds(*mResumed, first.file);
        mCheckpoint.restore(*mResumed, first, texture, mFinished);
        for (const std::filesystem::path& output : mFinished)
            mWriter.pass(output);
        mResumed.reset(); // with its state
    }

    void frameRead(const VelocityFrame& frame) override
    {
        const FrameFile& file = frame.file;
        mCheckpoint.noteInput(file.path, frame.stamp);
        mOutputs.startAt(file.frame);
        mOutputs.checkInputs(file);
    }

    void stepBegins() override
    {
        mCheckpoint.stepBegins();
        if (!std::exchange(mHasBegun, true)) mWatch = Stopwatch();
    }

    /// Called before the texture is written: if reporting its path fails, a checkpoint still covers this step.
    void stepDone(const RunPosition& position, const VelocityFrame& next) override
    {
        mCheckpoint.stepDone(position, next);
    }

    void textureDone() override
    {
        if (!mExchange.any(mExchange.isFirst() && mCheckpoint.isDue())) return;
        mWriter.finish(); // a checkpoint covers only outputs that are on disk
        mCheckpoint.write(mRun.texture());
    }

    /// Frames added later continue from the last step but one: the last one has no next frame.
    void lastBegins() override
    {
        mWriter.finish();
        if (mPlan.params.keepCheckpoint && mCheckpoint.isUnsaved()) mCheckpoint.write(mRun.texture());
    }

    void write(TextureFrame made)
    {
        const VelocityFrame& frame = made.frame;
        const std::int64_t number = mOutputs.number(frame.file.frame, made.substep);
        mReport.frames.push_back({number, made.domain->voxelCount(), made.stats, frame.readSeconds, made.times});
        mReporter.detail(frameLine(mReport.frames.back()));
        TextureFile file = makeTextureFile(mPlan, made, number, mExchange, mWriter.next());
        made.texture = {}; // frees each grid once its leaves are stored
        Stopwatch watch;
        std::vector<OwnLeaves> own = mRun.shared().store(frame, file, mWriter.isMineNext());
        mReport.frames.back().write = watch.lap();
        mWriter.write(mOutputs.texture(frame.file.frame, made.substep), std::move(file), std::move(own));
    }

    /// @param seconds from the first step to the last output
    void report(double seconds)
    {
        std::array<std::uint64_t, 2> sent = {mExchange.sent() - mWriter.sent(), mWriter.sent()};
        mExchange.sum(sent);
        if (!mExchange.isFirst()) return;
        if (!mExchange.isAlone()) {
            mReporter.detail(fmt::format("{} ranks exchanged {:.1f} MB in {} steps, and {:.1f} MB of outputs",
                                         mExchange.size(), double(sent[0]) / 1e6, mRun.steps(), double(sent[1]) / 1e6));
        }
        mReport.seconds = seconds;
        for (std::size_t i = 0; i < mReport.frames.size(); ++i)
            mReport.frames[i].write += mWriter.seconds()[i];
        for (const std::string& line : runLines(mReport))
            mReporter.detail(line);
        if (!mPlan.params.json.empty()) (void)writeReport(mPlan.params.json, toJson(mReport));
    }

    const AdvectPlan& mPlan;
    Reporter& mReporter;
    Exchange& mExchange;
    RunOutputs mOutputs;
    std::optional<OutputLock> mLock;
    RunCheckpoint mCheckpoint;
    std::size_t mTotal = 0;
    TextureRun mRun;
    FrameWriter mWriter;
    RunReport mReport;
    std::optional<Checkpoint> mResumed;           // until the run resumes from it
    std::vector<std::filesystem::path> mFinished; // outputs of the interrupted run
    Stopwatch mWatch;                             // since the first step
    bool mHasBegun = false;
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
    std::optional<AdvectPlan> plan;
    std::istringstream text;
    std::optional<Advection> advection;
    bool isRunning = false; // the same at all ranks
    try {
        params.validate();
        const bool isShared = params.flow.input.pattern == "-" && !exchange.isAlone();
        if (isShared) text.str(exchange.broadcast(exchange.isFirst() ? textOf(lines) : ""));
        plan.emplace(resolve(params, framesAround(params.flow.input)));
        AdvectParams none, said = plan->params, chosen = chosenParams(*plan);
        for (const std::string& line : planLines(parametersOf(none), parametersOf(said), parametersOf(chosen)))
            reporter.detail(line);
        if (const std::string leadIn = leadInText(*plan); !leadIn.empty()) reporter.say(leadIn);
        advection.emplace(*plan, isShared ? text : lines, reporter, exchange);
        exchange.agree();
        isRunning = true;
        advection->run();
        exchange.agree(); // also confirms that rank 0 wrote its report
    } catch (...) {
        exchange.fail(std::current_exception());
        if (isRunning) advection->abandon();
        throw;
    }
}

} // namespace vdblic
