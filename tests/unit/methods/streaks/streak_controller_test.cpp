#include "vdblic/methods/streaks/streak_controller.h"

#include "vdblic/field/box_domain.h"
#include "vdblic/field/domain_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace vdblic {
namespace {

constexpr std::array<float, 3> kTwo = {2, 2, 2};

Streak streakAt(const std::array<float, 3>& position, std::uint64_t name, double born)
{
    return {.name = name, .born = born, .path = {{position, {}, born}}};
}

double distance(const std::array<float, 3>& a, const std::array<float, 3>& b, const std::array<float, 3>& spacing)
{
    double sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        sum += std::pow(double(a[axis] - b[axis]) / double(spacing[axis]), 2);
    return std::sqrt(sum);
}

Domain boxDomain(const openvdb::CoordBBox& box)
{
    auto tree = std::make_shared<openvdb::MaskTree>();
    tree->fill(box, true, true);
    return Domain(tree);
}

std::vector<Streak> streaksAt(const std::vector<StreakPlace>& places)
{
    std::vector<Streak> streaks;
    streaks.reserve(places.size());
    for (const StreakPlace& place : places)
        streaks.push_back(streakAt(place.position, place.name, 0));
    return streaks;
}

std::size_t retire(std::vector<Streak>& streaks, double time)
{
    NeighbourhoodGrid heads(kTwo);
    addLive(streaks, 0, heads);
    return retireCrowded(streaks, heads, time);
}

std::vector<StreakPlace> placesBeside(const std::vector<Streak>& streaks, const std::array<float, 3>& spacing,
                                      const Domain& domain, const Domain& region, std::uint32_t seed,
                                      std::uint64_t turn)
{
    NeighbourhoodGrid heads(spacing);
    addLive(streaks, 0, heads);
    return freePlaces(streaks, heads, spacing, domain, region, seed, turn);
}

TEST(StreakController, OfTwoThatAreCrowdedTheYoungerRetires)
{
    std::vector<Streak> streaks = {streakAt({0, 0, 0}, 1, 5), streakAt({0.8f, 0, 0}, 2, 3), streakAt({3, 0, 0}, 3, 1),
                                   streakAt({3.95f, 0, 0}, 4, 0)};
    EXPECT_EQ(retire(streaks, 7), 1u);
    EXPECT_EQ(streaks[0].retired, 7); // 0.4 spacings from an older one
    EXPECT_TRUE(streaks[1].isLive());
    EXPECT_TRUE(streaks[2].isLive()); // 0.475 spacings are enough
    EXPECT_TRUE(streaks[3].isLive());
}

TEST(StreakController, OneThatRetiresRetiresNoOther)
{
    // In a row, each too near to the one before and far enough from the others: every second one stays.
    std::vector<Streak> streaks;
    streaks.reserve(5);
    for (int i = 0; i < 5; ++i)
        streaks.push_back(streakAt({0.8f * float(i), 0, 0}, std::uint64_t(i), i));
    EXPECT_EQ(retire(streaks, 9), 2u);
    for (std::size_t i = 0; i < 5; ++i)
        EXPECT_EQ(streaks[i].isLive(), i % 2 == 0) << i;
}

TEST(StreakController, RetiredAndStoppedOnesCrowdNobody)
{
    std::vector<Streak> streaks = {streakAt({0, 0, 0}, 1, 0), streakAt({0.1f, 0, 0}, 2, 1),
                                   streakAt({0, 0.1f, 0}, 3, 2)};
    streaks[0].retired = 3;
    streaks[1].isStopped = true;
    EXPECT_EQ(retire(streaks, 4), 0u);
}

TEST(StreakController, PlacesAreFreeAndApart)
{
    const Domain domain = boxDomain({{-5, 3, 0}, {24, 30, 19}});
    const std::array<float, 3> spacing = {2, 3, 1.5f};
    const std::vector<Streak> first = streaksAt(placesBeside({}, spacing, domain, domain, 1, 0));
    const double cells = 30 * 28 * 20 / (2 * 3 * 1.5);
    EXPECT_GT(double(first.size()), 0.3 * cells);
    EXPECT_LT(double(first.size()), 1.2 * cells);
    const std::vector<StreakPlace> more = placesBeside(first, spacing, domain, domain, 1, 1);
    EXPECT_GT(more.size(), 0u);
    EXPECT_LT(more.size(), first.size());
    std::vector<Streak> all = first;
    for (const Streak& streak : streaksAt(more))
        all.push_back(streak);
    for (std::size_t i = 0; i < all.size(); ++i) {
        const auto& at = all[i].path.back().position;
        EXPECT_TRUE(covers(domain, Float4{at[0], at[1], at[2], 0}));
        for (std::size_t j = 0; j < i; ++j)
            ASSERT_GE(distance(at, all[j].path.back().position, spacing), 0.8499) << i << ' ' << j;
    }
}

TEST(StreakController, PlacesAreTheSameInAPartOfTheDomain)
{
    const Domain domain = boxDomain({{0, 0, 0}, {31, 31, 31}}), part = boxDomain({{8, 8, 8}, {15, 15, 15}});
    const std::vector<StreakPlace> all = placesBeside({}, kTwo, domain, domain, 1, 0);
    for (const StreakPlace& place : placesBeside({}, kTwo, domain, part, 1, 0)) {
        EXPECT_TRUE(covers(part, Float4{place.position[0], place.position[1], place.position[2], 0}));
        const bool isThere =
            std::any_of(all.begin(), all.end(), [&](const StreakPlace& other) { return other.name == place.name; });
        // At the part's rim a place may be free whose better neighbour lies outside.
        const auto inside = [](float x) { return x > 9.5f && x < 13.5f; };
        if (inside(place.position[0]) && inside(place.position[1]) && inside(place.position[2])) {
            EXPECT_TRUE(isThere);
        }
    }
}

TEST(StreakController, PlacesOfAThinDomainLieInItsMiddle)
{
    const Domain layer = boxDomain({{0, 0, 4}, {40, 40, 4}});
    const std::vector<StreakPlace> places = placesBeside({}, kTwo, layer, layer, 1, 0);
    EXPECT_GT(places.size(), 100u);
    for (const StreakPlace& place : places)
        EXPECT_EQ(place.position[2], 4);
}

TEST(StreakController, SeedAndTurnMoveThePlaces)
{
    const Domain domain = boxDomain({{0, 0, 0}, {15, 15, 15}});
    const auto names = [&](std::uint32_t seed, std::uint64_t turn) {
        std::vector<std::uint64_t> result;
        for (const StreakPlace& place : placesBeside({}, kTwo, domain, domain, seed, turn))
            result.push_back(place.name);
        return result;
    };
    EXPECT_EQ(names(1, 0), names(1, 0));
    EXPECT_NE(names(1, 0), names(2, 0));
    EXPECT_NE(names(1, 0), names(1, 1));
}

} // namespace
} // namespace vdblic
