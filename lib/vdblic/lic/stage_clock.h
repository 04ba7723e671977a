#pragma once

#include "vdblic/core/stopwatch.h"

namespace vdblic {

/// Seconds of wall time spent, in the parts of Table 2 of Liu & Moorhead 2004.
struct StageTimes {
    double load = 0;     ///< building the velocity field
    double scatter = 0;  ///< advancing pathlines and depositing values
    double convolve = 0; ///< dividing sums by hits, and the mean along the flow
    double filter = 0;   ///< sharpening, contrast and noise

    StageTimes& operator+=(const StageTimes& other)
    {
        load += other.load;
        scatter += other.scatter;
        convolve += other.convolve;
        filter += other.filter;
        return *this;
    }
};

/// Adds up the time of a step's stages. An inner stage pauses the outer one's time. Not thread-safe.
class StageClock {
  public:
    /// Adds its lifetime to a stage.
    class Stage {
      public:
        Stage(StageClock& clock, double& seconds) : mClock(clock), mOuter(clock.mNow) { clock.switchTo(&seconds); }
        ~Stage() { mClock.switchTo(mOuter); }
        Stage(const Stage&) = delete;
        Stage& operator=(const Stage&) = delete;

      private:
        StageClock& mClock;
        double* mOuter;
    };
    [[nodiscard]] Stage enter(double StageTimes::*stage) { return {*this, mTimes.*stage}; }

    [[nodiscard]] const StageTimes& times() const { return mTimes; }

  private:
    void switchTo(double* seconds)
    {
        const double passed = mWatch.lap();
        if (mNow) *mNow += passed;
        mNow = seconds;
    }

    Stopwatch mWatch;
    StageTimes mTimes;
    double* mNow = nullptr; // the seconds of the innermost stage
};

} // namespace vdblic
