#include "vdblic/run/checkpoint_schedule.h"

#include <algorithm>

namespace vdblic {

bool CheckpointSchedule::isDue() const
{
    if (mEvery) return *mEvery > 0 && mSteps >= *mEvery;
    constexpr std::chrono::seconds kLeast{30};
    constexpr int kFraction = 50;
    return Clock::now() - mLast >= std::max<Clock::duration>(kLeast, mCost * kFraction);
}

void CheckpointSchedule::wrote(Clock::duration cost)
{
    mLast = Clock::now();
    mCost = cost;
    mSteps = 0;
}

} // namespace vdblic
