#include "cli/option_names.h"

#include "vdblic/coherence/coherence_params.h"
#include "vdblic/run/advect_params.h"

#include <gtest/gtest.h>

namespace vdblic::cli {
namespace {

TEST(OptionNames, StandInForParameters)
{
    EXPECT_EQ(withOptionNames("cut it with `mask`, or raise `max_memory`", {}),
              "cut it with --mask, or raise --max-memory");
    EXPECT_EQ(withOptionNames("`size`", {}), "--size");
}

TEST(OptionNames, FollowTheSpellingOfTheTool)
{
    AdvectParams run;
    const Parameters ofAdvect = parametersOf(run);
    EXPECT_EQ(withOptionNames("give `frame_spacing`, `life_span` or `world_box` to `output`", ofAdvect),
              "give --dt, --life or --bbox-world to --output");
    EXPECT_EQ(withOptionNames("choose with `texture_name`", ofAdvect), "choose with --texture-name");
    SequenceCoherenceParams measured;
    EXPECT_EQ(withOptionNames("choose with `texture_name`", parametersOf(measured)), "choose with --texture");
}

TEST(OptionNames, LeaveEverythingElseAlone)
{
    for (const char* message : {"", "nothing to replace", "a lone ` stays", "`A File.vdb`: damaged", "``", "`a b`"})
        EXPECT_EQ(withOptionNames(message, {}), message);
    EXPECT_EQ(withOptionNames("it`s odd: raise `max_memory`", {}), "it`s odd: raise --max-memory");
}

} // namespace
} // namespace vdblic::cli
