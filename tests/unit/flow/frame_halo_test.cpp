#include "vdblic/flow/frame_halo.h"

#include "distributed/thread_ranks.h"
#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;

TEST(HaloDepths, AreDeepOnlyNearFastVoxels)
{
    constexpr int kRanks = 4, kLeavesEach = 10;
    auto row = std::make_shared<openvdb::MaskTree>();
    row->denseFill({Coord(0), Coord(8 * kLeavesEach * kRanks - 1, 7, 7)}, true, true);
    const Partition partition(Domain(row), {1, 1, 1}, kRanks);
    std::vector<std::vector<Rim<Space::kTexture>>> depths(kRanks);
    test::ThreadRanks(kRanks).run([&](Exchange& exchange) {
        const float far = exchange.rank() == kRanks - 1 ? 40 : 1;
        depths[std::size_t(exchange.rank())] = haloDepths(exchange, partition, {{{far, 1, 1}}, {{2, 2, 2}}});
    });
    // 40 voxels are five leaves, and a cell reaches into the next. The last but one may lead into the last.
    const std::vector<Coord> expected = {Coord(16), Coord(16), Coord(48, 16, 16), Coord(48, 16, 16)};
    for (const std::vector<Rim<Space::kTexture>>& known : depths) {
        for (std::size_t rank = 0; rank < kRanks; ++rank)
            EXPECT_EQ(known.at(rank).voxels, expected[rank]) << rank;
    }
}

TEST(HaloDepths, FollowPathsThroughSeveralRanks)
{
    constexpr int kRanks = 4;
    auto row = std::make_shared<openvdb::MaskTree>();
    row->denseFill({Coord(0), Coord(8 * 3 * kRanks - 1, 7, 7)}, true, true); // three leaves each
    const Partition partition(Domain(row), {1, 1, 1}, kRanks);
    std::vector<std::vector<Rim<Space::kTexture>>> depths(kRanks);
    test::ThreadRanks(kRanks).run([&](Exchange& exchange) {
        const float far[] = {8, 30, 1, 100};
        depths[std::size_t(exchange.rank())] =
            haloDepths(exchange, partition, {{{far[exchange.rank()], 0, 0}}, {{0, 0, 0}}});
    });
    // From rank 0 paths lead into rank 1, there 30 voxels on, so into rank 2, but not into rank 3.
    EXPECT_EQ(depths[0][0].voxels, Coord(40, 16, 16));
    EXPECT_EQ(depths[0][3].voxels, Coord(112, 16, 16));
}

} // namespace
} // namespace vdblic
