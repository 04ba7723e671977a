#include "cli/parameter_options.h"

#include "cli/option_names.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace vdblic::cli {
namespace {

struct Kettle {
    int litres = 2;
    std::vector<std::string> herbs;
    std::array<double, 6> box{};
    bool whistles = false;
};
Parameters parametersOf(Kettle& kettle)
{
    return {
        parameter("water_level", "How full it is.", kettle.litres,
                  {.option = "--water", .unit = "l", .limits = {1, 9}}),
        parameter("herbs", "What goes in.", kettle.herbs, {.words = "NAME,NAME"}),
        parameter("box", "Where it stands.", kettle.box),
        parameter("whistles", "Whether one hears it.", kettle.whistles),
    };
}

/// One described parameter is all that an option, its help, its message and its JSON come from.
TEST(ParameterOptions, ComeFromTheDescriptionAlone)
{
    Kettle kettle;
    CLI::App app;
    const ParameterOptions options(app, parametersOf(kettle), {{kExpertGroup, {"whistles"}}});
    app.parse("--water 7 --herbs mint,sage --herbs thyme --box 1,2,3,4,5,6 --whistles");
    EXPECT_EQ(options.given().at("water_level"), Words{"7"});
    EXPECT_EQ(kettle.litres, 2); // until it is applied
    options.apply();
    EXPECT_EQ(kettle.litres, 7);
    EXPECT_EQ(kettle.herbs, (Words{"mint", "sage", "thyme"}));
    EXPECT_EQ(kettle.box, (std::array{1.0, 2.0, 3.0, 4.0, 5.0, 6.0}));
    EXPECT_TRUE(kettle.whistles);

    const std::string help = app.help();
    EXPECT_NE(help.find("--water INT=2"), std::string::npos) << help;
    EXPECT_NE(help.find("How full it is. A whole number from 1 to 9 [l]."), std::string::npos) << help;
    EXPECT_GT(help.find("--whistles"), help.find("Expert:")) << help;
    EXPECT_EQ(withOptionNames("raise `water_level`", options.parameters()), "raise --water");

    const auto list = nlohmann::json::parse(options.toJson());
    ASSERT_EQ(list.size(), 4u);
    EXPECT_EQ(list[0], nlohmann::json::parse(R"({"key": "water_level", "option": "--water", "type": "integer",
        "text": "How full it is.", "unit": "l", "default": "7", "least": 1.0, "most": 9.0})"));
    EXPECT_EQ(list[3]["expert"], true);
}

TEST(ParameterOptions, LeavePositionalArgumentsAlone)
{
    Kettle kettle;
    CLI::App app;
    std::string last;
    app.add_option("LAST", last);
    const ParameterOptions options(app, parametersOf(kettle));
    app.parse("--box 1 2 3 4 5 6 --herbs mint file.vdb");
    EXPECT_EQ(last, "file.vdb");
    EXPECT_EQ(options.given().at("box").size(), 6u);
    EXPECT_THROW(app.parse("--box 1 2 3"), CLI::ParseError);
}

} // namespace
} // namespace vdblic::cli
