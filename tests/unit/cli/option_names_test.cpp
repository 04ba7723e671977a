#include "cli/option_names.h"

#include "vdblic/coherence/coherence_params.h"
#include "vdblic/run/advect_params.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

namespace vdblic::cli {
namespace {

TEST(OptionNames, StandInForParameters)
{
    EXPECT_EQ(withOptionNames("put it aside with `scratch`, or raise `max_memory`", {}),
              "put it aside with --scratch, or raise --max-memory");
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
    EXPECT_EQ(withOptionNames("choose with `texture`", parametersOf(measured)), "choose with --texture");
}

TEST(OptionNames, NameTheToolThatHasAnOption)
{
    AdvectParams run;
    const Parameters ofAdvect = parametersOf(run);
    EXPECT_EQ(withOptionNames("cut the domain with `box` or `mask`", ofAdvect), "cut the domain with --bbox or --mask");
    SequenceCoherenceParams measured;
    EXPECT_EQ(withOptionNames("cut it with `box`", parametersOf(measured)), "cut it with --bbox of vdblic_advect");
    for (const char* key : {"box", "mask", "world_box"}) {
        const Parameter* const parameter = find(ofAdvect, key);
        ASSERT_NE(parameter, nullptr) << key;
        EXPECT_EQ(withOptionNames(fmt::format("`{}`", key), {}), parameter->option() + " of vdblic_advect");
    }
}

TEST(OptionNames, LeaveEverythingElseAlone)
{
    for (const char* message : {"", "nothing to replace", "a lone ` stays", "`A File.vdb`: damaged", "``", "`a b`"})
        EXPECT_EQ(withOptionNames(message, {}), message);
    EXPECT_EQ(withOptionNames("it`s odd: raise `max_memory`", {}), "it`s odd: raise --max-memory");
}

} // namespace
} // namespace vdblic::cli
