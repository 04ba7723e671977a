#include "view/state.h"

#include "cli/parameter_options.h"
#include "temporary_folder.h"
#include "vdblic/core/errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace vdblic::view {
namespace {

using Json = nlohmann::json;

/// The start that the words of a command line make.
Start startFrom(Words words)
{
    CLI::App app;
    PictureParams params;
    const cli::ParameterOptions options(app, parametersOf(params));
    std::reverse(words.begin(), words.end());
    app.parse(std::move(words));
    return startOf(options.given(), {.pattern = "lic.%04d.vdb", .frames = "1-3"});
}

TEST(State, IsWhatTheCommandLineSays)
{
    const std::pair<Words, const char*> cases[] = {
        {{}, "{}"},
        {{"--size", "64", "40", "--samples", "2"}, R"({"size": [64, 40], "samples": 2})"},
        {{"--fov", "50.25", "--look=ink"}, R"({"fov": 50.25, "look": "ink"})"},
        {{"--light", "-1", "0", "2", "--light", "0", "0", "1"}, R"({"light": [[-1, 0, 2], [0, 0, 1]]})"},
        {{"--clip-plane", "1", "2", "3", "0", "0", "1"}, R"({"clip-plane": [[1, 2, 3, 0, 0, 1]]})"},
        {{"--opacity", "0:0,1:0.5", "--annotate", "axes,time"}, R"({"opacity": "0:0,1:0.5", "annotate": "axes,time"})"},
        {{"--range", "-1.5", "2e-3"}, R"({"range": [-1.5, 2e-3]})"},
    };
    for (const auto& [words, state] : cases) {
        const Start start = startFrom(words);
        EXPECT_EQ(start.state, Json::parse(state));
        // State → arguments → state.
        EXPECT_EQ(startFrom(argumentsOf(start, start.state)).state, start.state);
    }
}

TEST(State, HasThePlanOfTheCommandLine)
{
    const Start start = startFrom({"--texture", "density"});
    const PicturePlan plan = planOf(start, Json::parse(R"({
        "size": [64, 40], "eye": [3, -4, 5.5], "projection": "orthographic", "view-height": 2,
        "look": "smoke", "opacity-by": "q", "range": [-1.5, 2], "light": [[1, 0, 2], [0, 1, 0]],
        "clip-plane": [[0.5, 0.5, 0.5, 1, 0, 0]], "background": [1, 0, 0.5], "solid": "domain",
        "keys": [{"frame": 1, "fov": 20}]})"));
    EXPECT_EQ(plan.texture, "density");
    EXPECT_EQ(plan.size, glm::ivec2(64, 40));
    EXPECT_EQ(plan.camera.eye, glm::dvec3(3, -4, 5.5));
    EXPECT_EQ(plan.camera.projection, Projection::kOrthographic);
    EXPECT_EQ(plan.opacityBy, Words{"q"});
    EXPECT_EQ(plan.look.transfer.range, (std::array{-1.5, 2.0}));
    ASSERT_EQ(plan.look.shading.lights.size(), 2); // in place of the look's
    EXPECT_EQ(plan.look.shading.lights[1].direction, glm::dvec3(0, 1, 0));
    EXPECT_EQ(plan.look.shading.ambient, 0.25f); // smoke's
    EXPECT_FALSE(plan.motion.keys.empty());
    // The command says the same.
    const Start again = startFrom(argumentsOf(start, Json::parse(R"({"eye": [3, -4, 5.5], "look": "smoke"})")));
    EXPECT_EQ(again.fixed, (std::map<std::string, Words>{{"texture", {"density"}}}));
    EXPECT_EQ(again.state, Json::parse(R"({"eye": [3, -4, 5.5], "look": "smoke"})"));
}

TEST(State, TakesKeyFramesFromTheirFile)
{
    const TemporaryFolder folder;
    const auto path = folder.add("keys.json", R"({"keys": [{"frame": 1, "fov": 20}]})");
    const Start start = startFrom({"--camera", path.string()});
    EXPECT_EQ(start.state, Json::parse(R"({"keys": [{"frame": 1, "fov": 20}]})"));
    EXPECT_EQ(argumentsOf(start, start.state), Words{});
    EXPECT_THROW((void)startFrom({"--camera", (folder / "none.json").string()}), InputError);
}

TEST(State, NamesNoFileButThoseOfTheCommandLine)
{
    const Start start = startFrom({"--transfer", "function.json", "--solid", "body.vdb"});
    EXPECT_EQ(start.fixed, (std::map<std::string, Words>{{"transfer", {"function.json"}}}));
    EXPECT_EQ(argumentsOf(start, Json::parse(R"({"solid": "body.vdb"})")),
              (Words{"--solid=body.vdb", "--transfer=function.json"}));
    for (const char* state :
         {R"({"transfer": "secret.json"})", R"({"camera": "secret.json"})", R"({"roi": "lic.vdb"})",
          R"({"solid": "/etc/passwd"})", R"({"solid": ["body.vdb"]})", R"({"texture": "q"})", R"({"output": "x.png"})",
          R"({"-o": "x.png"})", R"({"film": "x.mp4"})", R"({"config": "x"})", R"({"look --transfer": "x"})",
          R"({"--look": "flow"})", R"({"": 1})"})
        EXPECT_THROW((void)argumentsOf(start, Json::parse(state)), ParameterError) << state;
    // A value is one word, whatever is in it.
    EXPECT_EQ(argumentsOf(startFrom({}), Json::parse(R"({"look": "flow\n--transfer=x", "opacity": "--roi x"})")),
              (Words{"--look=flow\n--transfer=x", "--opacity=--roi x"}));
}

TEST(State, HostileValuesAreRefused)
{
    const Start start = startFrom({});
    std::string many = "[";
    for (int i = 0; i < 100; ++i)
        many += "[1,2,3],";
    many.back() = ']';
    for (const std::string& state :
         {std::string("3"), std::string("null"), std::string("[]"), std::string(R"({"fov": null})"),
          std::string(R"({"fov": true})"), std::string(R"({"fov": {}})"), std::string(R"({"eye": []})"),
          std::string(R"({"eye": [1, "x", 2]})"), std::string(R"({"light": [[1, 2, 3], 4]})"),
          std::string(R"({"light": [[[1, 2, 3]]]})"), R"({"light": )" + many + "}",
          R"({"opacity": ")" + std::string(20000, '0') + "\"}"})
        EXPECT_THROW((void)argumentsOf(start, Json::parse(state)), ParameterError) << state.substr(0, 60);
    // Values that are spelt as they should, but impossible.
    for (const char* state :
         {R"({"size": [0, 0]})", R"({"size": [1.5, 2]})", R"({"samples": 1000000})", R"({"fov": 200})",
          R"({"eye": [1, 2]})", R"({"eye": [1, 2, 3, 4]})", R"({"look": "sepia"})", R"({"opacity": "0:2"})",
          R"({"range": [2, 1]})", R"({"light": [[0, 0, 0]]})", R"({"keys": 7})", R"({"keys": [{"frame": "x"}]})",
          R"({"keys": [{"frame": 1, "eye": [0]}]})", R"({"colormap": "gray", "colors": "0:#000000,1:#ffffff"})"})
        EXPECT_THROW((void)planOf(start, Json::parse(state)), ParameterError) << state;
}

TEST(State, ACommandIsSafeInAShell)
{
    const Start start = startFrom({});
    EXPECT_EQ(commandOf(start, Json::parse(R"({"fov": 20, "eye": [1, -2, 0.5]})"), {"-o", "a.png"}),
              "vdblic_render lic.%04d.vdb --frames 1-3 --eye 1 -2 0.5 --fov=20 -o a.png");
    EXPECT_EQ(commandOf(start, Json::parse(R"({"annotate": "title=It's $(rm -r *) `x`"})"), {}),
              R"(vdblic_render lic.%04d.vdb --frames 1-3 '--annotate=title=It'\''s $(rm -r *) `x`')");
}

} // namespace
} // namespace vdblic::view
