#include "vdblic/run/texture_run.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/paging.h"
#include "vdblic/flow/frame_between.h"
#include "vdblic/methods/registry.h"
#include "vdblic/noise/noise_field.h"
#include "vdblic/noise/noise_file.h"
#include "vdblic/run/sequence_advice.h"

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <utility>

namespace vdblic {
namespace {

std::unique_ptr<FlowTexture> makeTexture(const AdvectParams& params)
{
    NoiseField noise(params.seed, params.noise.empty() ? nullptr : readNoise(params.noise));
    return makeFlowTexture(params, {std::move(noise), params.seed, params.flow.domain.refinement});
}

/// Flow parameters of the textures: streaks are traced on the velocity's own voxels.
VelocitySequenceParams flowOf(const AdvectPlan& plan)
{
    VelocitySequenceParams flow = plan.params.flow;
    flow.input = plan.input;
    if (plan.method().isSparse) flow.domain.refinement = {};
    return flow;
}

} // namespace

TextureRun::TextureRun(const AdvectPlan& plan, FrameSource source, Reporter& reporter, Exchange& exchange,
                       RunObserver& observer)
    : mPlan(plan), mReporter(reporter), mExchange(exchange), mObserver(observer), mShared(plan, exchange),
      mTexture(makeTexture(plan.params)), mFlow(flowOf(plan), std::move(source), reporter, exchange)
{
}

TextureRun::Iterator TextureRun::begin()
{
    const std::optional<RunPosition> from = mObserver.begins(mFlow);
    open();
    mObserver.opened(*mCurrent, !mNext, *mTexture);
    from ? goOn(*from) : start();
    mFlow.describe(*mCurrent, mInterval, mShared.largestDisplacement(*mCurrent, mInterval.seconds));
    checkMemoryFor(*mCurrent);
    advance();
    return Iterator(*this);
}

/// Make steps up to the next texture.
void TextureRun::advance()
{
    const bool hasMade = mMade.has_value();
    mMade.reset();
    if (hasMade && !mIsDone) mObserver.textureDone();
    while (!mMade && !mIsDone) {
        takeFrame();
        if (!mNext && mSteps >= mPlan.prerollSteps()) mObserver.lastBegins();
        mMade = step();
        if (mIsDone) return;
        mObserver.stepDone(position(), mStart ? *mStart : *mCurrent);
        if (!mMade) mObserver.textureDone();
    }
}

/// Read the first frames.
void TextureRun::open()
{
    mCurrent = nextFrame();
    mReporter.checkStop(); // a stop may have ended standard input
    if (!mCurrent) {
        const bool isStream = mPlan.input.pattern == "-";
        throw InputError(isStream ? "no frame to compute: standard input named none" : "no frame to compute");
    }
    mNext = nextFrame();
}

/// Start from the first frame.
void TextureRun::start()
{
    const std::optional<VelocityFrame>& end = mNext ? mNext : mAfter;
    mInterval = mFlow.intervalAfter(*mCurrent, end ? &*end : nullptr);
    // Summed up, as in a run over all frames.
    for (int i = 0; i < mPlan.framesBefore; ++i)
        mTime += mInterval.seconds;
    mTime = mCurrent->time.value_or(mTime);
    if (mPlan.params.voxelsPerFrame) setMotion(motionFor(*mPlan.params.voxelsPerFrame));
    chooseVoxels();
}

/// Let a texture that adapts to the flow choose its voxels. @throws ParameterError
void TextureRun::chooseVoxels()
{
    auto* const sparse = dynamic_cast<AdaptiveTexture*>(mTexture.get());
    if (!sparse) return;
    const double displacement = mShared.fasterDisplacement(*mCurrent, mInterval.seconds);
    mReporter.say(sparse->choose(*mCurrent->domain.velocity, displacement));
}

/// Start at the position of an interrupted run.
void TextureRun::goOn(const RunPosition& position)
{
    mSteps = position.steps;
    mTime = position.time;
    mInterval = {position.interval, "as before"};
    mFlow.setSpacing(position.frameSpacing);
    mSubstep = mPlan.substep(position.steps);
    setMotion(position.motion);
}

/// The factor, to three digits, that moves the current frame's faster half by so many voxels.
double TextureRun::motionFor(double voxels) const
{
    const double moves = mShared.fasterDisplacement(*mCurrent, mInterval.seconds);
    if (!(moves > 0)) return 1;
    const std::string factor = fmt::format("{:.3g}", voxels / moves);
    mReporter.say(
        fmt::format("the faster half of frame {} moves {:.2g} voxels, and {:.2g} with `motion` {}, which gives "
                    "other parts of the sequence the same motion",
                    mCurrent->file.frame, moves, voxels, factor));
    return std::stod(factor);
}

void TextureRun::setMotion(double motion)
{
    mFlow.setMotion(motion);
    for (std::optional<VelocityFrame>* frame : {&mCurrent, &mNext, &mAfter}) {
        if (*frame) (*frame)->motion = motion;
    }
}

/// Report a run's memory; refuse a run that needs too much now, not after minutes.
void TextureRun::checkMemoryFor(const VelocityFrame& first) const
{
    const double bytes = mPlan.method().bytes(mPlan.params, first.domain, mPlan.params.flow.domain.refinement,
                                              mPlan.params.writesHits());
    const std::string voxels = fmt::format("{} {} voxels", first.domain.texture->voxelCount(),
                                           mPlan.method().isSparse ? "velocity" : "texture");
    const std::string each = mExchange.isAlone() ? "" : fmt::format(" each for {} ranks", mExchange.size());
    const std::string text = fmt::format("{}: about {} of memory{}", voxels, memoryText(bytes), each);
    first.domain.refinement.isNone() ? mReporter.detail(text) : mReporter.say(text);
    constexpr double kLeast = 0.75; // of the estimate
    // Tiles occupy no bytes of a file: a damaged one may have any number.
    const openvdb::Vec3STree& values = first.values->tree();
    const auto stored = double(values.activeLeafVoxelCount()), all = double(values.activeVoxelCount());
    const bool isStored = bytes * (all - stored) <= double(memoryLimit()) * all;
    if (isStored && paging::makeRoom(bytes)) {
        mReporter.say(fmt::format("{} take about {}, and {} of memory may be used: the rest lies in a scratch file",
                                  voxels, memoryText(bytes), memoryText(double(memoryLimit()))));
    } else {
        const std::string tool = hasMemoryOption() ? "" : ", or let vdblic_advect do it, which takes a scratch file";
        checkMemory(kLeast * bytes, voxels, "lower `refine`, or cut the domain with `box` or `mask`" + tool);
    }
}

std::optional<VelocityFrame> TextureRun::nextFrame()
{
    std::optional<VelocityFrame> frame = mFlow.next();
    mShared.checkSame(frame ? frame->stamp : "");
    if (frame) {
        mObserver.frameRead(*frame);
    } else {
        mAfter = mFlow.after();
        mShared.checkSame(mAfter ? mAfter->stamp : "");
    }
    return frame;
}

/// Advance to the next frame after a frame's last substep.
void TextureRun::takeFrame()
{
    if (!mNext || mSubstep < mPlan.substeps()) return;
    mTime += mInterval.seconds;
    mCurrent = std::move(mNext);
    mNext = nextFrame();
    mStart.reset();
    mSubstep = 0;
}

/// Make a step. @return its texture; nothing if it only prepares later ones
std::optional<TextureFrame> TextureRun::step()
{
    if (mSteps < mPlan.prerollSteps()) {
        mShared.surround(*mCurrent, *mCurrent, mInterval.seconds, *mTexture);
        (void)makeStep(*mCurrent, *mCurrent, *mCurrent, mTime, false);
        return std::nullopt;
    }
    return mNext ? stepBetweenFrames() : lastStep();
}

/// A substep between the current frame and the next.
std::optional<TextureFrame> TextureRun::stepBetweenFrames()
{
    if (!mStart) {
        mInterval = mFlow.intervalAfter(*mCurrent, &*mNext);
        balance(*mCurrent);
        mShared.surround(*mCurrent, *mNext, mInterval.seconds, *mTexture);
        mStart = at(mSubstep);
    }
    VelocityFrame end = at(mSubstep + 1);
    const bool isWritten = mSteps >= mPlan.warmUpSteps();
    const double time = mTime + mSubstep * mInterval.seconds / mPlan.substeps();
    TextureFrame made = makeStep(*mStart, end, *mNext, time, isWritten);
    mStart = std::move(end);
    ++mSubstep;
    if (!isWritten) return std::nullopt;
    if (made.substep == 0) warnOfOddFlow(made.frame, made.interval);
    return made;
}

/// The flow at a substep between the current frame and the next.
VelocityFrame TextureRun::at(int substep) const
{
    const int substeps = mPlan.substeps();
    return substep == 0          ? *mCurrent
           : substep == substeps ? *mNext
                                 : frameBetween(*mCurrent, *mNext, double(substep) / substeps);
}

/// The texture of the last frame; without a next frame the flow is steady.
TextureFrame TextureRun::lastStep()
{
    VelocityFrame& last = *mCurrent;
    VelocityFrame end = last;
    if (mAfter) {
        const int substeps = mPlan.substeps();
        mInterval = mFlow.intervalAfter(last, &*mAfter);
        mShared.surround(last, *mAfter, mInterval.seconds, *mTexture);
        end = substeps == 1 ? *mAfter : frameBetween(last, *mAfter, 1.0 / substeps);
    } else {
        mShared.surround(last, end, mInterval.seconds, *mTexture);
    }
    mIsDone = true;
    TextureFrame made = makeStep(last, end, mAfter ? *mAfter : last, mTime, true);
    warnOfOddFlow(made.frame, made.interval);
    return made;
}

/// Balance the ranks' parts of a frame before a step starts from it.
void TextureRun::balance(VelocityFrame& frame)
{
    const std::optional<std::string> how = mSteps > 0 ? mShared.balance(frame, *mTexture) : std::nullopt;
    if (!how) return;
    mFlow.cutAs(frame.partition);
    mReporter.detail(fmt::format("frame {}: {}", frame.file.frame, *how));
}

/// @param next frame on disk after the current one, at the end of the step's whole interval
TextureFrame TextureRun::makeStep(const VelocityFrame& start, const VelocityFrame& end, const VelocityFrame& next,
                                  double time, bool isShown)
{
    if (mExchange.any(mReporter.stopRequested())) throw Stopped{};
    mObserver.stepBegins();
    const std::unique_ptr<const LeafOwners> owners = mShared.ownersOf(start);
    const FlowStep whole{.start = *mCurrent, .end = next, .interval = mInterval.seconds};
    TextureFrame made = mTexture->advance({.start = start,
                                           .end = end,
                                           .interval = mInterval.seconds,
                                           .substeps = mPlan.substeps(),
                                           .substep = mSubstep,
                                           .time = time,
                                           .owners = *owners,
                                           .whole = &whole,
                                           .isShown = isShown,
                                           .withHits = isShown && mPlan.params.writesHits()});
    ++mSteps;
    return made;
}

/// The position between two steps.
RunPosition TextureRun::position() const
{
    const bool isNextFrame = mNext && mSubstep == mPlan.substeps();
    return {mSteps, mInterval.seconds, isNextFrame ? mTime + mInterval.seconds : mTime, mFlow.spacing(),
            mCurrent->motion};
}

/// Warn of a suspicious frame whose texture can be computed.
void TextureRun::warnOfOddFlow(const VelocityFrame& frame, double seconds)
{
    const std::int64_t number = frame.file.frame;
    if (frame.domain.texture->voxelCount() == 0) {
        const bool isCut = mExchange.any(frame.values->activeVoxelCount() > 0);
        mReporter.warn(
            fmt::format("{}: {}; its texture is empty", frame.file.label(),
                        isCut ? "no active voxel lies inside `box`, `world_box` and `mask`" : "no active voxels"));
        return;
    }
    const double largest = mShared.largestDisplacement(frame, seconds);
    constexpr double kRest = 1e-3; // voxels a step
    if (largest < kRest && !mWarnedOfRest) {
        mWarnedOfRest = true;
        mReporter.warn(fmt::format("{}: grid {} moves nothing by more than {:.3g} voxels a step, and a "
                                   "texture without motion shows no direction: check unit and frame spacing",
                                   frame.file.label(), frame.gridName, largest));
    }
    // A streak's tail suits the displacement.
    if (mPlan.method().isSparse || mPlan.method().isSteady || largest <= kLargeDisplacement || mWarnedOfDisplacement)
        return;
    const double faster = mShared.fasterDisplacement(frame, seconds);
    if (faster <= kLargeDisplacement) return;
    mWarnedOfDisplacement = true;
    const auto advice = motionAdvice(faster, {number});
    mReporter.warn(fmt::format("frame {}: {}", number, *advice));
}

} // namespace vdblic
