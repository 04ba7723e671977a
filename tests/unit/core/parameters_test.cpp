#include "vdblic/core/parameters.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdblic {

enum class Weather { kFair, kFoul };
template<>
inline constexpr auto kNames<Weather> = std::to_array<std::string_view>({"fair", "foul"});

namespace {

struct Voyage {
    int days = 3;
    float speed = 4.5f;
    double least = 0.1;
    bool isFast = false;
    std::string ship;
    Weather weather = Weather::kFair;
    std::optional<double> load;
    std::array<double, 3> from{1, 2, 3};
    std::vector<std::string> crew;
};
Parameters parametersOf(Voyage& voyage)
{
    return {
        parameter("days", "Days.", voyage.days, {.limits = {1, 30}}),
        parameter("speed", "Speed.", voyage.speed, {.option = "--knots", .limits = {0, 40, true}}),
        parameter("least", "Least.", voyage.least),
        parameter("fast", "Fast.", voyage.isFast),
        parameter("ship", "Ship.", voyage.ship),
        parameter("weather", "Weather.", voyage.weather),
        parameter("load", "Load.", voyage.load, {.excludes = "days"}),
        parameter("from_where", "From.", voyage.from),
        parameter("crew", "Crew.", voyage.crew),
    };
}

std::string refusal(Voyage& voyage, const std::map<std::string, Words>& given)
{
    try {
        set(parametersOf(voyage), given);
    } catch (const ParameterError& error) {
        return error.what();
    }
    return "taken";
}

TEST(Parameters, AreSetByWords)
{
    Voyage voyage;
    set(parametersOf(voyage), {{"days", {"7"}},
                               {"speed", {"0.1"}},
                               {"fast", {"true"}},
                               {"ship", {"Fram"}},
                               {"weather", {"foul"}},
                               {"from_where", {"-1", "2.5", "1e3"}},
                               {"crew", {"Ada", "Bo"}}});
    EXPECT_EQ(voyage.days, 7);
    EXPECT_EQ(voyage.speed, 0.1f);
    EXPECT_TRUE(voyage.isFast);
    EXPECT_EQ(voyage.ship, "Fram");
    EXPECT_EQ(voyage.weather, Weather::kFoul);
    EXPECT_FALSE(voyage.load);
    EXPECT_EQ(voyage.from, (std::array{-1.0, 2.5, 1000.0}));
    EXPECT_EQ(voyage.crew, (Words{"Ada", "Bo"}));
}

TEST(Parameters, TextsReadBackToTheBit)
{
    Voyage voyage{.days = 30, .speed = std::nextafter(0.1f, 1.0f), .least = 1.0 / 3, .load = -1e-300};
    const Parameters parameters = parametersOf(voyage);
    std::map<std::string, Words> texts;
    for (const Parameter& parameter : parameters) {
        if (!parameter.get().empty() && parameter.key != "days") texts[std::string(parameter.key)] = parameter.get();
    }
    Voyage copy;
    set(parametersOf(copy), texts);
    EXPECT_EQ(copy.speed, voyage.speed);
    EXPECT_EQ(copy.least, voyage.least);
    EXPECT_EQ(copy.load, voyage.load);
    EXPECT_EQ(find(parameters, "from_where")->value(), "1 2 3");
    EXPECT_EQ(find(parameters, "ship")->value(), "");
    EXPECT_EQ(find(parameters, "nothing"), nullptr);
}

TEST(Parameters, RefuseWhatDoesNotFitAndSayWhatWould)
{
    Voyage voyage;
    EXPECT_EQ(refusal(voyage, {{"days", {"31"}}}), "`days` cannot be 31; it is a whole number from 1 to 30");
    EXPECT_EQ(refusal(voyage, {{"days", {"2.5"}}}), "`days` cannot be 2.5; it is a whole number from 1 to 30");
    EXPECT_EQ(refusal(voyage, {{"speed", {"0"}}}), "`speed` cannot be 0; it is a number above 0 up to 40");
    EXPECT_EQ(refusal(voyage, {{"speed", {"nan"}}}), "`speed` cannot be nan; it is a number above 0 up to 40");
    EXPECT_EQ(refusal(voyage, {{"speed", {"3 knots"}}}), "`speed` cannot be 3 knots; it is a number above 0 up to 40");
    EXPECT_EQ(refusal(voyage, {{"weather", {"mild"}}}), "`weather` cannot be mild; it is one of fair, foul");
    EXPECT_EQ(refusal(voyage, {{"from_where", {"1", "2"}}}), "`from_where` cannot be 1 2; it is 3 numbers");
    EXPECT_EQ(refusal(voyage, {{"fast", {"yes"}}}), "`fast` cannot be yes; it is true or false");
    EXPECT_EQ(refusal(voyage, {{"sails", {"3"}}}), "there is no parameter `sails`");
    EXPECT_EQ(refusal(voyage, {{"load", {"1"}}, {"days", {"2"}}}), "`load` and `days` exclude each other");
    EXPECT_EQ(voyage.days, 3); // nothing was set
    voyage.days = 0;
    EXPECT_THROW(checkLimits(parametersOf(voyage)), ParameterError);
}

} // namespace
} // namespace vdblic
