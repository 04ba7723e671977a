#include "vdblic/field/leaf_voxel.h"

#include "vdblic/field/domain.h"
#include "vdblic/field/domain_rows.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <numeric>

namespace vdblic {
namespace {

using openvdb::Coord;

TEST(LeafVoxel, HasTheOffsetsOfOpenVdb)
{
    for (unsigned offset = 0; offset < unsigned(LeafVoxel::kCount); ++offset) {
        const LeafVoxel voxel = LeafVoxel::at(offset);
        ASSERT_EQ(Coord(voxel.x, voxel.y, voxel.z), Domain::Leaf::offsetToLocalCoord(offset));
        ASSERT_EQ(LeafVoxel::offset(voxel.x, voxel.y, voxel.z), int(offset));
    }
    for (const Coord& at : {Coord(0, 0, 0), Coord(-1, -8, -9), Coord(7, 8, 15), Coord(-131072, 131071, -3)}) {
        ASSERT_EQ(unsigned(LeafVoxel::offset(at[0], at[1], at[2])), Domain::Leaf::coordToOffset(at)) << at;
    }
}

TEST(LeafVoxel, RowsFollowEachOtherAlongZ)
{
    for (int row = 0; row < LeafVoxel::kRows; ++row) {
        const LeafVoxel first = LeafVoxel::ofRow(row);
        EXPECT_EQ(first.z, 0);
        EXPECT_EQ(LeafVoxel::row(first.x, first.y), row);
        EXPECT_EQ(LeafVoxel::offset(first.x, first.y, first.z), LeafVoxel::kDim * row);
    }
}

TEST(LeafVoxel, RowsAreLoadedAndStoredWhole)
{
    std::array<float, LeafVoxel::kCount> from{}, to{};
    std::array<std::int32_t, LeafVoxel::kCount> whole{};
    std::iota(from.begin(), from.end(), 1.0f);
    std::iota(whole.begin(), whole.end(), 1);
    for (int row = 0; row < LeafVoxel::kRows; ++row) {
        storeRow(loadRow(from.data(), row), to.data(), row);
        EXPECT_EQ(loadRow(whole.data(), row)[7], 8 * row + 8);
    }
    EXPECT_EQ(to, from);
}

TEST(LeafVoxel, SplitsCoordinatesIntoLeafAndRest)
{
    for (const int x : {-17, -16, -9, -8, -1, 0, 7, 8, 100}) {
        EXPECT_EQ(8 * LeafVoxel::leafCoordinate(x) + LeafVoxel::local(x), x);
        EXPECT_TRUE(LeafVoxel::local(x) >= 0 && LeafVoxel::local(x) < 8) << x;
    }
}

TEST(LeafBlock, NumbersLeavesAsOpenVdbsNodes)
{
    using Node = openvdb::MaskTree::RootNodeType::ChildNodeType::ChildNodeType;
    static_assert(Node::NUM_VALUES == LeafBlock::kCount && Node::DIM == 1 << LeafBlock::kLog2Voxels);
    for (const Coord& at : {Coord(0, 0, 0), Coord(8, 16, 24), Coord(-1, -8, -128), Coord(127, 128, 300)}) {
        EXPECT_EQ(unsigned(LeafBlock::leafIndex(at[0], at[1], at[2])), Node::coordToOffset(at)) << at;
    }
}

} // namespace
} // namespace vdblic
