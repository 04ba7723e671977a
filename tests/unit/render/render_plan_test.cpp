#include "vdblic/render/render_plan.h"

#include "temporary_folder.h"
#include "vdblic/core/errors.h"
#include "vdblic/look/look_preset.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace vdblic {
namespace {

PictureParams paramsOf(const Given& given, bool isReversed = false)
{
    PictureParams params;
    Parameters parameters = parametersOf(params);
    if (isReversed) std::reverse(parameters.begin(), parameters.end());
    set(parameters, given);
    return params;
}

/// All values, by key.
Given valuesOf(PictureParams params)
{
    Given values;
    for (const Parameter& parameter : parametersOf(params))
        values[std::string(parameter.key)] = parameter.get();
    return values;
}

class RenderPlans : public testing::Test {
  protected:
    TemporaryFolder mFolder;
    const std::string mTransfer = mFolder.add("transfer.json", R"({"colormap": "viridis", "range": [1, 2]})");
    const std::string mKeys = mFolder.add("keys.json", R"({"keys": [{"frame": 1, "fov": 20}]})");
    const Given mGiven{{"look", {"ink"}},           {"transfer", {mTransfer}}, {"range", {"3", "5"}}, {"by", {"q"}},
                       {"opacity_by", {"density"}}, {"camera", {mKeys}},       {"halo", {"0.7"}}};
};

TEST_F(RenderPlans, OptionsStandOnTheFileThatStandsOnTheLook)
{
    const PicturePlan plan = resolve(paramsOf(mGiven), {});
    EXPECT_EQ(plan.look.shading.model, ShadingModel::kLine); // ink's
    EXPECT_EQ(plan.look.transfer.colorMap, "viridis");       // the file's
    EXPECT_EQ(plan.look.transfer.range, (std::array{3.0, 5.0}));
    EXPECT_EQ(plan.look.halo, 0.7);
    EXPECT_EQ(plan.colorBy, "q");
    EXPECT_EQ(plan.opacityBy, Words{"density"});
    EXPECT_EQ(plan.motion.keys.fieldOfView.at(1), 20);
}

TEST_F(RenderPlans, TheOrderOfTheParametersHasNoMeaning)
{
    const PictureParams back = paramsOf(mGiven, /*isReversed=*/true);
    EXPECT_EQ(valuesOf(back), valuesOf(paramsOf(mGiven)));
    EXPECT_EQ(valuesOf(resolve(back, {}).params()), valuesOf(resolve(paramsOf(mGiven), {}).params()));
}

TEST_F(RenderPlans, FilesAreReadWhenParametersAreResolved)
{
    for (const char* key : {"transfer", "camera"}) {
        const PictureParams params = paramsOf({{key, {(mFolder / "none.json").string()}}});
        EXPECT_THROW((void)resolve(params, {}), InputError) << key;
    }
}

TEST_F(RenderPlans, TheirValuesGiveThemAgain)
{
    for (const std::string& name : lookPresetNames()) {
        const PictureParams all = resolve(paramsOf({{"look", {name}}, {"occlusion", {"0.3"}}}), {}).params();
        EXPECT_EQ(all.look, name);
        PictureParams given = all;
        if (given.lookOptions.contains("colors")) given.lookOptions.erase("colormap"); // they exclude each other
        EXPECT_EQ(valuesOf(resolve(given, {}).params()), valuesOf(all)) << name;
    }
}

TEST_F(RenderPlans, FollowWhatTheSequenceHolds)
{
    EXPECT_EQ(resolve(PictureParams{}, {}).lookName, "flow");
    EXPECT_EQ(resolve(PictureParams{}, {.isSparse = true}).lookName, "streaks");
    EXPECT_EQ(resolve(paramsOf({{"look", {"flow"}}}), {.isSparse = true}).lookName, "flow");
    const PictureParams vortex = paramsOf({{"look", {"vortex"}}});
    EXPECT_EQ(resolve(vortex, {}).opacityBy, (Words{"q", "vorticity"}));
    EXPECT_EQ(resolve(vortex, {.scalars = {"magnitude", "vorticity"}}).opacityBy, Words{"vorticity"});
    const PictureParams orbit = paramsOf({{"orbit", {"1"}}});
    EXPECT_THROW((void)resolve(orbit, {.isNumbered = false}), ParameterError);
    EXPECT_EQ(resolve(orbit, {.isNumbered = true}).motion.orbit, 1);
}

} // namespace
} // namespace vdblic
