#include "vdblic/core/free_runs.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

TEST(FreeRuns, GivesEachPlaceOnceAndJoinsNeighbours)
{
    constexpr std::uint32_t kPlaces = 5000;
    FreeRuns runs(kPlaces);
    runs.add({0, kPlaces});
    std::mt19937 random(1);
    std::vector<bool> isTaken(kPlaces);
    std::vector<FreeRuns::Range> taken;
    for (int turn = 0; turn < 20000; ++turn) {
        if (random() % 2 == 0) {
            const auto count = std::uint32_t(1 + random() % (turn % 10 == 0 ? 400 : 5));
            const std::optional<std::uint32_t> first = runs.take(count);
            if (!first) continue;
            for (std::uint32_t place = *first; place < *first + count; ++place) {
                ASSERT_FALSE(isTaken.at(place));
                isTaken[place] = true;
            }
            taken.push_back({*first, count});
        } else if (!taken.empty()) {
            std::swap(taken[random() % taken.size()], taken.back());
            const FreeRuns::Range range = taken.back();
            taken.pop_back();
            for (std::uint32_t place = range.first; place < range.first + range.count; ++place)
                isTaken[place] = false;
            runs.add(range);
        }
    }
    for (const FreeRuns::Range& range : taken)
        runs.add(range);
    const std::optional<FreeRuns::Range> all = runs.takeAny();
    ASSERT_TRUE(all);
    EXPECT_EQ(all->first, 0u);
    EXPECT_EQ(all->count, kPlaces);
    EXPECT_FALSE(runs.takeAny());
}

TEST(FreeRuns, FindsALongRangeBesideAMillionShortOnes)
{
    constexpr std::uint32_t kShort = 1 << 20, kLong = 7;
    FreeRuns runs(2 * kShort + kLong);
    for (std::uint32_t i = 0; i < kShort; ++i)
        runs.add({2 * i, 1});
    for (int turn = 0; turn < 1000000; ++turn) // some minutes if it looked at all of them each time
        ASSERT_FALSE(runs.take(2));
    runs.add({2 * kShort, kLong});
    EXPECT_EQ(runs.take(5), std::optional<std::uint32_t>(2 * kShort));
    EXPECT_EQ(runs.take(2), std::optional<std::uint32_t>(2 * kShort + 5));
    EXPECT_FALSE(runs.take(2));
}

} // namespace
} // namespace vdblic
