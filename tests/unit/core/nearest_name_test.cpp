#include "vdblic/core/nearest_name.h"

#include <gtest/gtest.h>

namespace vdblic {
namespace {

TEST(NearestName, BeginsWithTheWordOrDiffersInFewLetters)
{
    const std::vector<std::string> names = {"frames", "fps", "refine", "finish"};
    EXPECT_EQ(nearestName("frame", names), "frames");
    EXPECT_EQ(nearestName("fr", names), "frames");
    EXPECT_EQ(nearestName("refnie", names), "refine");
    EXPECT_EQ(nearestName("colour", names), std::nullopt);
    EXPECT_EQ(nearestName("refine", {}), std::nullopt);
}

} // namespace
} // namespace vdblic
