#include "vdblic/run/advect_plan.h"

#include "temporary_folder.h"
#include "vdblic/methods/lic/lic.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <vector>

namespace vdblic {
namespace {

/// A plan for frames 5 and 6 of a sequence that has frames 1 to 6.
AdvectPlan planIn(const TemporaryFolder& folder, AdvectParams params)
{
    for (int frame = 1; frame <= 6; ++frame)
        folder.add(fmt::format("v.{}.vdb", frame));
    params.flow.input.pattern = (folder / "v.%d.vdb").string();
    params.flow.input.frames = "5-6";
    return resolve(params, framesAround(params.flow.input));
}

TEST(AdvectPlan, LeavesWhatTheUserSaidAsItWas)
{
    const TemporaryFolder folder;
    const AdvectPlan plan = planIn(folder, {});
    EXPECT_EQ(plan.params.flow.input.frames, "5-6");
    EXPECT_FALSE(plan.params.preroll || plan.params.leadIn || plan.params.finish);
}

TEST(AdvectPlan, LeadsInFromAsManyFramesAsThereAre)
{
    const TemporaryFolder folder;
    const AdvectPlan plan = planIn(folder, {});
    EXPECT_EQ(selectedFrames(plan.input), (std::vector<std::int64_t>{1, 2, 3, 4, 5, 6}));
    EXPECT_EQ(plan.leadIn, 4);
    EXPECT_EQ(plan.framesBefore, 0);
    EXPECT_EQ(plan.preroll, 4); // as a run over all frames
    EXPECT_EQ(plan.textures(6), 2u);
    EXPECT_EQ(leadInText(plan), "frames 1 to 4 are computed first and not written");
}

TEST(AdvectPlan, LetsALeadInStandInForThePreroll)
{
    const TemporaryFolder folder;
    AdvectParams params;
    params.leadIn = 1;
    const AdvectPlan plan = planIn(folder, params);
    EXPECT_EQ(selectedFrames(plan.input), (std::vector<std::int64_t>{4, 5, 6}));
    EXPECT_EQ(plan.framesBefore, 3);
    EXPECT_EQ(plan.preroll, 0);
    EXPECT_EQ(leadInText(plan),
              "frame 4 is computed first and not written; with `lead_in` 4 the textures would be those "
              "of a run over all frames");
}

TEST(AdvectPlan, CountsStepsAndTextures)
{
    AdvectParams params;
    params.preroll = 2;
    params.texture.substeps = 3;
    const AdvectPlan plan = resolve(params);
    EXPECT_EQ(plan.prerollSteps(), 6u);
    EXPECT_EQ(plan.framesDone(5), 0u);
    EXPECT_EQ(plan.framesDone(11), 1u);
    EXPECT_EQ(plan.substep(11), 2);
    EXPECT_EQ(plan.texturesDone(11), 5u);
    EXPECT_EQ(plan.textures(4), 10u);
    EXPECT_EQ(plan.textures(0), 0u);
}

TEST(AdvectPlan, TakesTheDefaultsOfTheMethod)
{
    AdvectParams params;
    EXPECT_EQ(resolve(params).finish, 2);
    params.texture.method = &kLic;
    const AdvectPlan plan = resolve(params);
    EXPECT_EQ(plan.finish, 0);
    EXPECT_EQ(plan.preroll, 0);
}

} // namespace
} // namespace vdblic
