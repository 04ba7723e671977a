#include "vdblic/core/exchange.h"
#include "vdblic/core/reporter.h"
#include "vdblic/distributed/leaf_delivery.h"

#include "distributed/thread_ranks.h"
#include "temporary_folder.h"
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;

/// Leaves of one voxel each, more than travel in one chunk.
openvdb::FloatGrid::Ptr manyLeaves(float scale)
{
    auto grid = openvdb::FloatGrid::create(0);
    auto accessor = grid->getAccessor();
    for (int i = 0; i < 9 * 31 * 31; ++i) {
        const Coord leaf(i / (31 * 31), i / 31 % 31, i % 31);
        accessor.setValue(Coord(8 * leaf[0], 8 * leaf[1], 8 * leaf[2]), scale * float(i % 997));
    }
    return grid;
}

/// What a thread that writes gets.
struct Taken {
    StoredLeaves leaves;
    std::string records;
};

Taken takeAll(LeafStream& stream)
{
    Taken taken{stream.leaves(), {}};
    for (std::string block; !(block = stream.block()).empty();)
        taken.records += block;
    return taken;
}

std::string bytesIn(const std::filesystem::path& path)
{
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

TEST(LeafDelivery, BringsAllLeavesInOrder)
{
    constexpr int kRanks = 4, kWriters = 2;
    const std::vector<openvdb::FloatGrid::Ptr> grids = {manyLeaves(1), manyLeaves(0.5f)};
    const Domain domain(std::make_shared<openvdb::MaskTree>(grids[0]->tree(), false, true, openvdb::TopologyCopy()));
    std::vector<std::uint32_t> every(domain.leafCount());
    std::iota(every.begin(), every.end(), 0u);
    std::vector<Taken> taken(kWriters);
    test::ThreadRanks(kRanks).run([&](Exchange& exchange) {
        const int rank = exchange.rank();
        std::vector<std::uint32_t> own; // the last rank has none
        for (const std::uint32_t leaf : every) {
            if (int(leaf / 7 % (kRanks - 1)) == rank) own.push_back(leaf);
        }
        const std::shared_ptr<const Domain> part = domain.ofRank(own, own);
        std::vector<OwnLeaves> leaves;
        leaves.reserve(grids.size());
        for (const auto& grid : grids)
            leaves.push_back(storeOwn(*part, *grid, VdbCompression::kBlosc));
        LeafStream stream(1);
        const bool isWriter = rank < kWriters;
        std::future<Taken> writer;
        if (isWriter) writer = std::async(std::launch::async, [&] { return takeAll(stream); });
        deliver(exchange, std::move(leaves), isWriter ? &stream : nullptr);
        if (isWriter) taken[std::size_t(rank)] = writer.get();
    });
    for (std::size_t i = 0; i < taken.size(); ++i) {
        const OwnLeaves whole = storeOwn(domain, *grids[i], VdbCompression::kBlosc);
        std::string records;
        for (const std::string& block : whole.stored.blocks)
            records += block;
        EXPECT_EQ(taken[i].leaves.lengths, whole.stored.lengths);
        EXPECT_EQ(taken[i].leaves.kinds, whole.stored.kinds);
        EXPECT_EQ(taken[i].leaves.sizes, whole.stored.sizes);
        EXPECT_TRUE(taken[i].records == records) << i;
    }
}

// A process alone writes so, too.
TEST(LeafDelivery, AFileOfStoredLeavesIsTheSame)
{
    const TemporaryFolder folder;
    OneProcess alone;
    const openvdb::FloatGrid::Ptr floats = manyLeaves(0.25f);
    const Domain domain(std::make_shared<openvdb::MaskTree>(floats->tree(), false, true, openvdb::TopologyCopy()));
    for (const char* precision : {"unsaid", "half", "full", "integers"}) {
        openvdb::GridBase::Ptr grid = floats->deepCopy();
        if (precision == std::string("integers"))
            grid = openvdb::Int32Grid::create(std::make_shared<openvdb::Int32Tree>(floats->tree()));
        grid->setName(precision);
        if (precision != std::string("unsaid")) grid->setSaveFloatAsHalf(precision == std::string("half"));
        const std::filesystem::path whole = folder / "whole.vdb", stored = folder / "stored.vdb";
        writeStoredVdb(whole, {grid}, {}, VdbCompression::kBlosc, nullptr);
        LeafStream stream(1);
        std::vector<OwnLeaves> leaves;
        leaves.push_back(storeOwn(domain, *grid, VdbCompression::kBlosc));
        deliver(alone, std::move(leaves), &stream);
        writeStoredVdb(stored, {withoutValues(domain, *grid)}, {}, VdbCompression::kBlosc, &stream);
        EXPECT_TRUE(bytesIn(stored) == bytesIn(whole)) << precision;
    }
}

TEST(LeafDelivery, NobodyWaitsForAWriterThatGaveUp)
{
    LeafStream stream(1);
    stream.begin({});
    stream.giveUp();
    for (int i = 0; i < 20; ++i)
        stream.give(std::string(std::size_t(32) << 20, 'x')); // more than may wait
    EXPECT_THROW(stream.leaves(), Stopped);
}

} // namespace
} // namespace vdblic
