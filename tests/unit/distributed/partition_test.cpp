#include "vdblic/distributed/partition.h"

#include "vdblic/field/box_domain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <random>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;

Domain boxOfVoxels(const CoordBBox& box)
{
    auto topology = std::make_shared<openvdb::MaskTree>();
    topology->fill(box, true, true);
    return Domain(topology);
}

std::vector<std::size_t> voxelsOf(const Domain& domain, const Partition& partition)
{
    std::vector<std::size_t> voxels;
    for (int rank = 0; rank < partition.ranks(); ++rank) {
        std::size_t sum = 0;
        for (const std::uint32_t leaf : leavesIn(domain, partition.box(rank).voxels))
            sum += domain.mask(leaf).countOn();
        voxels.push_back(sum);
    }
    return voxels;
}

TEST(Partition, GivesEveryVoxelOneOwner)
{
    const Domain domain = boxOfVoxels({Coord(-37, 5, -900), Coord(90, 60, -811)});
    std::mt19937 random(5);
    for (int ranks = 1; ranks <= 9; ++ranks) {
        const Partition partition(domain, {3, 1, 2}, ranks);
        for (int i = 0; i < 2000; ++i) {
            const auto at = [&] { return int(random() % 4000) - 2000; };
            const Coord voxel(at(), at(), at());
            int owners = 0;
            for (int rank = 0; rank < ranks; ++rank) {
                const bool isInside = partition.textureBox(rank).voxels.isInside(voxel);
                owners += isInside;
                EXPECT_EQ(isInside, partition.owner({voxel}) == rank) << voxel;
            }
            EXPECT_EQ(owners, 1);
        }
    }
}

TEST(Partition, CutsBetweenLeavesIntoEqualParts)
{
    const Domain domain = boxOfVoxels({Coord(0, 0, 0), Coord(127, 63, 63)});
    for (const int ranks : {2, 4, 8, 16}) {
        const Partition partition(domain, {2, 2, 2}, ranks);
        for (const std::size_t voxels : voxelsOf(domain, partition))
            EXPECT_EQ(voxels, domain.voxelCount() / std::size_t(ranks));
        for (int rank = 0; rank < ranks; ++rank) {
            for (int axis = 0; axis < 3; ++axis) {
                EXPECT_EQ(partition.box(rank).voxels.min()[axis] % 8, 0);
                EXPECT_EQ(partition.textureBox(rank).voxels.min()[axis] % 16, 0);
            }
        }
    }
    const auto voxels = voxelsOf(domain, Partition(domain, {1, 1, 1}, 5));
    EXPECT_LT(double(*std::max_element(voxels.begin(), voxels.end())), 1.3 * double(domain.voxelCount()) / 5);
}

TEST(Partition, LeavesRanksWithoutWork)
{
    const Domain one = boxOfVoxels({Coord(3, 3, 3), Coord(4, 4, 4)});
    const auto voxels = voxelsOf(one, Partition(one, {1, 1, 1}, 4));
    EXPECT_EQ(std::count(voxels.begin(), voxels.end(), 8u), 1);
    EXPECT_EQ(std::count(voxels.begin(), voxels.end(), 0u), 3);
    const Domain none(std::make_shared<openvdb::MaskTree>());
    const Partition empty(none, {1, 1, 1}, 3);
    EXPECT_GE(empty.owner({Coord(0)}), 0);
}

} // namespace
} // namespace vdblic
