#include "vdblic/run/checkpoint_schedule.h"

#include <gtest/gtest.h>

#include <optional>

namespace vdblic {
namespace {

TEST(CheckpointSchedule, CountsSteps)
{
    CheckpointSchedule every3(3), none(0), byTime(std::nullopt);
    EXPECT_TRUE(every3.enabled());
    EXPECT_FALSE(none.enabled());
    EXPECT_TRUE(byTime.enabled());
    for (int i = 1; i < 10; ++i) {
        for (CheckpointSchedule* schedule : {&every3, &none, &byTime})
            schedule->stepDone();
        EXPECT_EQ(every3.isDue(), i % 3 == 0);
        EXPECT_FALSE(none.isDue());
        EXPECT_FALSE(byTime.isDue()); // not before half a minute
        if (every3.isDue()) every3.wrote({});
    }
}

} // namespace
} // namespace vdblic
