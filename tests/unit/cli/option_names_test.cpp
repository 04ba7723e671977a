#include "cli/option_names.h"

#include <gtest/gtest.h>

namespace vdblic::cli {
namespace {

TEST(OptionNames, StandInForParameters)
{
    EXPECT_EQ(withOptionNames("cut it with `mask`, or raise `max_memory`", "vdblic_advect"),
              "cut it with --mask, or raise --max-memory");
    EXPECT_EQ(withOptionNames("`size`", "vdblic_render"), "--size");
}

TEST(OptionNames, FollowTheSpellingOfTheTool)
{
    EXPECT_EQ(withOptionNames("give `frame_spacing`, `life_span` or `world_box`", "vdblic_advect"),
              "give --dt or --fps, --life or --bbox-world");
    EXPECT_EQ(withOptionNames("choose with `texture_name`", "vdblic_advect"), "choose with --texture-name");
    EXPECT_EQ(withOptionNames("choose with `texture_name`", "vdblic_coherence"), "choose with --texture");
}

TEST(OptionNames, LeaveEverythingElseAlone)
{
    for (const char* message : {"", "nothing to replace", "a lone ` stays", "`A File.vdb`: damaged", "``", "`a b`"})
        EXPECT_EQ(withOptionNames(message, "vdblic_diff"), message);
    EXPECT_EQ(withOptionNames("it`s odd: raise `max_memory`", "vdblic_diff"), "it`s odd: raise --max-memory");
}

} // namespace
} // namespace vdblic::cli
