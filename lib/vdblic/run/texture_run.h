#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/core/reporter.h"
#include "vdblic/flow/velocity_sequence.h"
#include "vdblic/io/sequence.h"
#include "vdblic/methods/flow_texture.h"
#include "vdblic/run/advect_plan.h"
#include "vdblic/run/checkpoint.h"
#include "vdblic/run/shared_run.h"

#include <cstddef>
#include <iterator>
#include <memory>
#include <optional>

namespace vdblic {

/// Displacements beyond this cause a warning [voxels per step]: velocity is hardly linear in time over such a distance.
inline constexpr double kLargeDisplacement = 16;

/// Callbacks of a run for the writers of textures and checkpoints. Called in the run's thread, at all ranks alike; the
/// default implementations do nothing.
class RunObserver {
  public:
    virtual ~RunObserver() = default;

    /// Called before the first frame is read. @return the position to resume from; nothing: start with the first frame
    [[nodiscard]] virtual std::optional<RunPosition> begins(VelocitySequence& /*flow*/) { return std::nullopt; }
    /// Called when the first frames are read. A resumed texture gets its state here. @param isOnly whether no other
    /// frame follows
    virtual void opened(const VelocityFrame& /*first*/, bool /*isOnly*/, FlowTexture& /*texture*/) {}
    virtual void frameRead(const VelocityFrame& /*frame*/) {}
    virtual void stepBegins() {}
    /// Called after each step but the last. @param next flow from which the next step starts
    virtual void stepDone(const RunPosition& /*position*/, const VelocityFrame& /*next*/) {}
    /// Called after each step but the last, once its texture, if any, is passed on.
    virtual void textureDone() {}
    /// Called when only the last frame's step is left.
    virtual void lastBegins() {}
};

/// The textures of a velocity sequence, in order: a single-pass range.
///
///     for (TextureFrame& texture : run) write(std::move(texture));
///
/// Makes all steps: preroll, lead-in, every frame with its substeps, and the last one. Reads frames on demand, and
/// writes nothing. Advancing is collective if several ranks share the run. Not thread-safe.
class TextureRun {
  public:
    class Iterator {
      public:
        explicit Iterator(TextureRun& run) : mRun(&run) {}
        [[nodiscard]] TextureFrame& operator*() const { return *mRun->mMade; }
        Iterator& operator++()
        {
            mRun->advance();
            return *this;
        }
        [[nodiscard]] bool operator==(std::default_sentinel_t /*end*/) const { return !mRun->mMade; }

      private:
        TextureRun* mRun;
    };

    /// All references must outlive this. @param source of the frames
    /// @throws ParameterError; InputError if the noise cannot be read
    TextureRun(const AdvectPlan& plan, FrameSource source, Reporter& reporter, Exchange& exchange,
               RunObserver& observer);

    /// Read the first frames and make steps up to the first texture. Called once.
    /// @throws InputError, also if there is no frame, or the run needs more memory than allowed
    /// @throws Stopped before a step if the reporter requests a stop; so does the iterator
    [[nodiscard]] Iterator begin();
    [[nodiscard]] static std::default_sentinel_t end() { return {}; }

    /// Whether the next texture needs a frame that is not read yet, if there is one.
    [[nodiscard]] bool needsFrame() const { return mNext && mSubstep == mPlan.substeps(); }
    [[nodiscard]] bool isDone() const { return mIsDone; }        ///< whether the texture made is the last
    [[nodiscard]] std::uint64_t steps() const { return mSteps; } ///< made, preroll included
    [[nodiscard]] const FlowTexture& texture() const { return *mTexture; }
    [[nodiscard]] const SharedRun& shared() const { return mShared; }

  private:
    void advance();
    void open();
    void start();
    void goOn(const RunPosition& position);
    void takeFrame();
    [[nodiscard]] std::optional<TextureFrame> step();
    [[nodiscard]] RunPosition position() const;
    void chooseVoxels();
    void setMotion(double motion);
    [[nodiscard]] double motionFor(double voxels) const;
    void checkMemoryFor(const VelocityFrame& first) const;
    [[nodiscard]] std::optional<VelocityFrame> nextFrame();
    void balance(VelocityFrame& frame);
    [[nodiscard]] VelocityFrame at(int substep) const;
    [[nodiscard]] std::optional<TextureFrame> stepBetweenFrames();
    [[nodiscard]] TextureFrame lastStep();
    [[nodiscard]] TextureFrame makeStep(const VelocityFrame& start, const VelocityFrame& end, const VelocityFrame& next,
                                        double time, bool isShown);
    void warnOfOddFlow(const VelocityFrame& frame, double seconds);

    const AdvectPlan& mPlan;
    Reporter& mReporter;
    Exchange& mExchange;
    RunObserver& mObserver;
    SharedRun mShared;
    std::unique_ptr<FlowTexture> mTexture;
    VelocitySequence mFlow;
    std::uint64_t mSteps = 0;
    std::optional<TextureFrame> mMade; // shown by the iterators
    std::optional<VelocityFrame> mCurrent, mNext;
    std::optional<VelocityFrame> mAfter; // on disk after the last frame, once that is reached
    std::optional<VelocityFrame> mStart; // of the next substep; nothing before an interval's first
    FrameInterval mInterval{};           // between the current frame and the next
    int mSubstep = 0;                    // next one after the current frame
    double mTime = 0;                    // of the current frame
    bool mIsDone = false;
    bool mWarnedOfDisplacement = false, mWarnedOfRest = false;
};

} // namespace vdblic
