#include "vdblic/render/frames_in_flight.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

namespace vdblic {
namespace {

TEST(FramesInFlight, AreAsManyAsThreadsWhereHalfTheMemoryHoldsThem)
{
    EXPECT_EQ(framesInFlight(1e9, 4, 8e9), 4u);
    EXPECT_EQ(framesInFlight(1e9, 4, 7.9e9), 3u);
    EXPECT_EQ(framesInFlight(1e9, 4, 2e9), 1u);
    EXPECT_EQ(framesInFlight(1e9, 16, 20e9), 10u);
}

TEST(FramesInFlight, AreAtLeastOne)
{
    EXPECT_EQ(framesInFlight(1e18, 4, 8e9), 1u);
    EXPECT_EQ(framesInFlight(0, 4, 8e9), 4u);
    EXPECT_EQ(framesInFlight(1e18), 1u);
}

TEST(FramesInFlight, FollowTheThreadsOfTheArenaAndTheirLimit)
{
    tbb::task_arena arena(3);
    const auto inArena = [&] { return arena.execute([] { return framesInFlight(1); }); };
    const tbb::global_control three(tbb::global_control::max_allowed_parallelism, 3);
    EXPECT_EQ(inArena(), 3u);
    const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);
    EXPECT_EQ(inArena(), 2u);
}

} // namespace
} // namespace vdblic
