#pragma once

#include <chrono>
#include <optional>

namespace vdblic {

/// Schedules a run's checkpoints.
class CheckpointSchedule {
  public:
    using Clock = std::chrono::steady_clock;

    /// @param every steps between checkpoints; 0: none; nothing: by time, see isDue()
    explicit CheckpointSchedule(std::optional<int> every) : mEvery(every) {}

    [[nodiscard]] bool enabled() const { return mEvery != 0; }
    void stepDone() { ++mSteps; }

    /// By time, a checkpoint is due half a minute after the last one, or later to keep their cost below a fiftieth of
    /// the run.
    [[nodiscard]] bool isDue() const;

    /// Record a checkpoint. @param cost time to write it
    void wrote(Clock::duration cost);

  private:
    std::optional<int> mEvery;
    int mSteps = 0; // since the last checkpoint
    Clock::time_point mLast = Clock::now();
    Clock::duration mCost{}; // of the last checkpoint
};

} // namespace vdblic
