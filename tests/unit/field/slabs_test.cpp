#include "vdblic/field/slabs.h"

#include "vdblic/field/leaf_voxel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <set>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;

/// Boxes of leaves, in voxels.
Domain domainOf(std::initializer_list<openvdb::CoordBBox> boxes, const Period& period = {})
{
    const auto topology = std::make_shared<openvdb::MaskTree>();
    for (const openvdb::CoordBBox& box : boxes)
        topology->denseFill(box, true);
    return Domain(topology, 1, period);
}

/// A long domain with a gap across it.
Domain longDomain(const Period& period = {})
{
    return domainOf({{{-512, 0, 0}, {-1, 127, 127}}, {{64, 0, 0}, {255, 127, 127}}}, period);
}

TEST(Slabs, HoldEveryLeafOnce)
{
    const Domain domain = longDomain();
    const Slabs slabs(domain);
    EXPECT_EQ(slabs.axis(), 0);
    EXPECT_GT(slabs.size(), 10u);
    std::vector<int> held(domain.leafCount(), 0);
    int last = -1000;
    for (std::size_t slab = 0; slab < slabs.size(); ++slab) {
        int most = last;
        for (const std::uint32_t leaf : slabs[slab]) {
            ++held[leaf];
            const int layer = LeafVoxel::leafCoordinate(domain.origin(leaf)[0]);
            EXPECT_GT(layer, last);
            most = std::max(most, layer);
        }
        EXPECT_TRUE(std::is_sorted(slabs[slab].begin(), slabs[slab].end()));
        last = most;
    }
    EXPECT_EQ(held, std::vector<int>(domain.leafCount(), 1));
}

void checkSweeps(const Domain& domain, int period)
{
    const Slabs slabs(domain);
    for (const int reach : {0, 1, 5, 1 << 20}) {
        std::set<std::uint32_t> open;
        std::size_t opened = 0, closed = 0, mostOpen = 0, worked = 0;
        slabs.sweep(
            reach,
            [&](std::size_t slab) {
                const Slabs::Leaves leaves = slabs[slab];
                opened += leaves.size();
                open.insert(leaves.begin(), leaves.end());
            },
            [&](std::size_t slab) {
                for (const std::uint32_t leaf : slabs[slab])
                    closed += open.erase(leaf);
            },
            [&](std::size_t slab) {
                const Slabs::Leaves leaves = slabs[slab];
                mostOpen = std::max(mostOpen, open.size());
                worked += leaves.size();
                const int first = LeafVoxel::leafCoordinate(domain.origin(leaves.front())[0]),
                          last = LeafVoxel::leafCoordinate(domain.origin(leaves.back())[0]);
                for (std::uint32_t leaf = 0; leaf < domain.leafCount(); ++leaf) {
                    const int layer = LeafVoxel::leafCoordinate(domain.origin(leaf)[0]);
                    const auto isFar = [&](int at) { return at < first - reach || at > last + reach; };
                    if (isFar(layer) && isFar(layer + period) && isFar(layer - period)) continue;
                    ASSERT_EQ(open.count(leaf), 1u) << "layer " << layer << " from " << first << " to " << last;
                }
            });
        EXPECT_EQ(worked, domain.leafCount());
        EXPECT_EQ(opened, domain.leafCount());
        EXPECT_EQ(closed, domain.leafCount());
        if (reach <= 1) {
            EXPECT_LT(2 * mostOpen, domain.leafCount());
        }
    }
}

TEST(Slabs, ASweepHasEverythingWithinReachOpen)
{
    checkSweeps(longDomain(), 0);
}

TEST(Slabs, ASweepReachesAcrossTheSeamOfAPeriodicBox)
{
    constexpr int kPeriod = 768;
    checkSweeps(longDomain({{-512, 0, 0}, {kPeriod, 0, 0}}), kPeriod / LeafVoxel::kDim);
}

TEST(Slabs, LieAcrossTheLongestAxis)
{
    EXPECT_EQ(Slabs(domainOf({{{0, 0, 0}, {7, 7, 63}}})).axis(), 2);
}

TEST(Slabs, AnEmptyDomainHasNone)
{
    EXPECT_EQ(Slabs(Domain(std::make_shared<openvdb::MaskTree>())).size(), 0u);
}

} // namespace
} // namespace vdblic
