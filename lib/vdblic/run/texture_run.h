#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/core/reporter.h"
#include "vdblic/flow/flow_sequence.h"
#include "vdblic/io/sequence.h"
#include "vdblic/methods/flow_texture.h"
#include "vdblic/run/advect_plan.h"
#include "vdblic/run/checkpoint.h"
#include "vdblic/run/shared_run.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

namespace vdblic {

/// A run warns of displacements longer than this [voxels per step]: over such a distance velocity is hardly linear in
/// time.
inline constexpr double kLargeDisplacement = 16;

/// A texture of a run, and when it is valid.
struct RunTexture {
    LoadedFrame frame;   ///< the flow of that time
    int substep = 0;     ///< its number after the frame on disk
    double time = 0;     ///< seconds
    double interval = 0; ///< seconds between the frames on disk around it
    FlowTextureStep step;

    [[nodiscard]] openvdb::math::Transform::Ptr transform() const ///< of the texture
    {
        return step.refinement.refined(frame.velocity.values->transform());
    }
};

/// The textures of a velocity sequence, one step after the other: preroll, lead-in, every frame with its substeps, and
/// the last one. It reads frames as it needs them, and writes nothing.
///
/// All functions that are not const are collective if several ranks share the run. Not thread-safe.
class TextureRun {
  public:
    /// What the caller does at certain moments of the run; nothing if empty.
    struct Hooks {
        std::function<void(const LoadedFrame&)> frameRead;
        std::function<void()> stepBegins;
    };

    /// All references must outlive this. @param source of the frames
    /// @throws ParameterError; InputError if the noise cannot be read
    TextureRun(const AdvectPlan& plan, FrameSource source, Reporter& reporter, Exchange& exchange,
               Hooks hooks = {});

    /// Read the first frames. @throws InputError, also if there is none
    void open();
    [[nodiscard]] const LoadedFrame& firstFrame() const { return *mCurrent; } ///< after open()
    [[nodiscard]] bool isOnlyFrame() const { return !mNext; }                 ///< after open()

    /// Start from the first frame. @throws InputError if the run needs more memory than it may take
    void begin();
    /// Start where an interrupted run was; texture() has its state. @throws as begin()
    void goOn(const RunPosition& position);

    /// Whether a step is left to make; reads a frame if the step needs one.
    [[nodiscard]] bool hasStep();
    [[nodiscard]] bool isDone() const { return mIsDone; } ///< whether the last step is made
    /// Whether the step to make is of the last frame. After hasStep().
    [[nodiscard]] bool isLast() const { return !mNext && mSteps >= mPlan.prerollSteps(); }
    /// Make a step. @return its texture; nothing if it only prepares those to come
    /// @throws Stopped before the step if the reporter asks for that; InputError
    [[nodiscard]] std::optional<RunTexture> step();

    /// Where the run is between two steps, and the flow that the next one starts from.
    [[nodiscard]] RunPosition position() const;
    [[nodiscard]] const LoadedFrame& frame() const { return mStart ? *mStart : *mCurrent; }

    [[nodiscard]] std::uint64_t steps() const { return mSteps; } ///< made, preroll included
    [[nodiscard]] FlowTexture& texture() { return *mTexture; }
    [[nodiscard]] const FlowTexture& texture() const { return *mTexture; }
    [[nodiscard]] FlowSequence& flow() { return mFlow; }
    [[nodiscard]] const SharedRun& shared() const { return mShared; }

  private:
    void start();
    void chooseVoxels();
    void setMotion(double motion);
    [[nodiscard]] double motionFor(double voxels) const;
    void checkMemoryFor(const LoadedFrame& first) const;
    [[nodiscard]] std::optional<LoadedFrame> nextFrame();
    void balance(LoadedFrame& frame);
    [[nodiscard]] LoadedFrame at(int substep) const;
    [[nodiscard]] std::optional<RunTexture> stepBetweenFrames();
    [[nodiscard]] RunTexture lastStep();
    [[nodiscard]] FlowTextureStep advance(const LoadedFrame& start, const LoadedFrame& end, const LoadedFrame& next,
                                          bool isShown);
    void warnOfOddFlow(const LoadedFrame& frame, double seconds);

    const AdvectPlan& mPlan;
    Reporter& mReporter;
    Exchange& mExchange;
    Hooks mHooks;
    SharedRun mShared;
    std::unique_ptr<FlowTexture> mTexture;
    FlowSequence mFlow;
    std::uint64_t mSteps = 0;
    std::optional<LoadedFrame> mCurrent, mNext;
    std::optional<LoadedFrame> mAfter; // on disk after the last frame, once that is reached
    std::optional<LoadedFrame> mStart; // of the next substep; nothing before an interval's first
    FrameInterval mInterval{};         // between the current frame and the next
    int mSubstep = 0;                  // to come after the current frame
    double mTime = 0;                  // of the current frame
    bool mIsDone = false;
    bool mWarnedOfDisplacement = false, mWarnedOfRest = false;
};

} // namespace vdblic
