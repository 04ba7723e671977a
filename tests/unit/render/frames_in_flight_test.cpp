#include "vdblic/render/frames_in_flight.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace vdblic {
namespace {

TEST(FramesInFlight, AreAsManyAsThreadsAndMemoryAllow)
{
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(framesInFlight(1), 1u);
    EXPECT_EQ(framesInFlight(1e18), 1u); // there is always one
    EXPECT_EQ(framesInFlight(0), 1u);
}

TEST(FramesInFlight, FallWithTheSizeOfAFrame)
{
    const std::size_t small = framesInFlight(1e3), large = framesInFlight(1e18);
    EXPECT_GE(small, large);
    EXPECT_EQ(large, 1u);
}

} // namespace
} // namespace vdblic
