#include "vdblic/methods/auflic/tile_schedule.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <thread>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;

/// A box of leaves with one active voxel each, without those that `isHole` takes out.
template<typename IsHole>
Domain leavesIn(const Coord& size, const IsHole& isHole)
{
    auto topology = std::make_shared<openvdb::MaskTree>();
    for (const Coord& at : openvdb::CoordBBox(Coord(0), size.offsetBy(-1))) {
        if (!isHole(at)) topology->setValueOn(Coord(8 * at[0], 8 * at[1], 8 * at[2]));
    }
    return Domain(topology);
}

Domain leavesIn(const Coord& size)
{
    return leavesIn(size, [](const Coord&) { return false; });
}

std::vector<std::uint32_t> allLeaves(const Domain& domain)
{
    std::vector<std::uint32_t> leaves(domain.leafCount());
    std::iota(leaves.begin(), leaves.end(), 0u);
    return leaves;
}

/// Whether a leaf of one group is within twice the reach of a leaf of the other along every axis: threads that compute
/// the groups could write to the same leaf.
bool couldMeet(const Domain& domain, Slabs::Leaves some, Slabs::Leaves others, const Coord& reach)
{
    return std::any_of(some.begin(), some.end(), [&](std::uint32_t a) {
        return std::any_of(others.begin(), others.end(), [&](std::uint32_t b) {
            const Coord apart = domain.origin(a) - domain.origin(b);
            return std::abs(apart[0]) <= 16 * reach[0] && std::abs(apart[1]) <= 16 * reach[1] &&
                   std::abs(apart[2]) <= 16 * reach[2];
        });
    });
}

/// What threads saw that took every group of a schedule.
struct Observed {
    std::vector<int> visits; ///< of each leaf
    std::size_t meetings = 0, mostTogether = 0;
};

/// Let threads take all groups. @param together threads that are to hold a group at the same time, waited for at first
Observed takeAll(const Domain& domain, const Coord& reach, std::size_t threads, std::size_t together = 1)
{
    const std::vector<std::uint32_t> leaves = allLeaves(domain);
    TileSchedule schedule(domain, leaves, reach, threads);
    Observed observed{std::vector<int>(domain.leafCount(), 0)};
    std::vector<Slabs::Leaves> held(threads);
    std::mutex mutex;
    std::condition_variable took;
    const auto work = [&](std::size_t thread) {
        while (const std::optional<TileSchedule::Group> group = schedule.next(thread)) {
            {
                std::unique_lock lock(mutex);
                for (const Slabs::Leaves& others : held)
                    observed.meetings += couldMeet(domain, group->leaves, others, reach);
                held[thread] = group->leaves;
                for (const std::uint32_t leaf : group->leaves)
                    ++observed.visits[leaf];
                const auto atWork =
                    std::count_if(held.begin(), held.end(), [](const auto& some) { return !some.empty(); });
                observed.mostTogether = std::max(observed.mostTogether, std::size_t(atWork));
                took.notify_all();
                constexpr std::chrono::seconds kPatience(20); // only a failing test waits as long
                took.wait_for(lock, kPatience, [&] { return observed.mostTogether >= together; });
            }
            std::this_thread::yield();
            const std::lock_guard lock(mutex);
            held[thread] = {};
        }
    };
    std::vector<std::thread> workers;
    for (std::size_t thread = 0; thread < threads; ++thread)
        workers.emplace_back(work, thread);
    for (std::thread& worker : workers)
        worker.join();
    return observed;
}

TEST(TileSchedule, GivesEveryLeafOnceAndNeverTwoGroupsThatCouldMeet)
{
    const auto isHole = [](const Coord& at) { return (at[0] + 2 * at[1] + 3 * at[2]) % 5 == 0; };
    const Domain domain = leavesIn({9, 7, 12}, isHole);
    for (const Coord& reach : {Coord(0, 0, 0), Coord(1, 1, 1), Coord(3, 1, 0), Coord(0, 2, 1)}) {
        for (const std::size_t threads : {1, 2, 9}) {
            const Observed observed = takeAll(domain, reach, threads);
            EXPECT_EQ(observed.visits, std::vector<int>(domain.leafCount(), 1)) << reach << threads;
            EXPECT_EQ(observed.meetings, 0u) << reach << threads;
        }
    }
}

TEST(TileSchedule, GivesGroupsThatAreFarApartTogether)
{
    // Along a line of 40 leaves every second group of eight is farther than two leaves from every other.
    const Domain domain = leavesIn({1, 1, 40});
    const Observed observed = takeAll(domain, {1, 1, 1}, 3, 2);
    EXPECT_GE(observed.mostTogether, 2u);
    EXPECT_EQ(observed.meetings, 0u);
    EXPECT_EQ(observed.visits, std::vector<int>(40, 1));
}

TEST(TileSchedule, GivesOneGroupAfterTheOtherWhereAllAreNear)
{
    const Domain domain = leavesIn({6, 6, 6});
    const Observed observed = takeAll(domain, {3, 3, 3}, 4);
    EXPECT_EQ(observed.mostTogether, 1u);
    EXPECT_EQ(observed.visits, std::vector<int>(216, 1));
}

TEST(TileSchedule, ReleasesTheThreadsThatWaitForOneThatFailed)
{
    const Domain domain = leavesIn({6, 6, 6});
    const std::vector<std::uint32_t> leaves = allLeaves(domain);
    TileSchedule schedule(domain, leaves, {3, 3, 3}, 2);
    EXPECT_TRUE(schedule.next(0).has_value()); // and does not come back
    std::optional<TileSchedule::Group> other;
    std::thread waiting([&] { other = schedule.next(1); });
    schedule.stop();
    waiting.join();
    EXPECT_FALSE(other.has_value());
}

TEST(TileSchedule, OfNoLeavesIsDoneAtOnce)
{
    const Domain domain = leavesIn({1, 1, 1});
    TileSchedule schedule(domain, {}, {1, 1, 1}, 2);
    EXPECT_FALSE(schedule.next(0).has_value());
    EXPECT_FALSE(schedule.next(1).has_value());
}

} // namespace
} // namespace vdblic
