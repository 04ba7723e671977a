#pragma once

#include <chrono>
#include <optional>

namespace vdblic {

/// When a run writes its checkpoints.
class CheckpointSchedule {
  public:
    using Clock = std::chrono::steady_clock;

    /// @param every steps between checkpoints; 0: none; nothing: by time, see isDue()
    explicit CheckpointSchedule(std::optional<int> every) : mEvery(every) {}

    [[nodiscard]] bool enabled() const { return mEvery != 0; }
    void stepDone() { ++mSteps; }

    /// By time, a checkpoint is due half a minute after the last one, or later if writing them would otherwise take
    /// more than a fiftieth of the run.
    [[nodiscard]] bool isDue() const;

    /// A checkpoint was written. @param cost time that writing it took
    void wrote(Clock::duration cost);

  private:
    std::optional<int> mEvery;
    int mSteps = 0; // since the last checkpoint
    Clock::time_point mLast = Clock::now();
    Clock::duration mCost{}; // of the last checkpoint
};

} // namespace vdblic
