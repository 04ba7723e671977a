#include "vdblic/field/leaf_window.h"

#include <gtest/gtest.h>

#include <memory>
#include <set>

namespace vdblic {
namespace {

using openvdb::Coord;

/// Leaves about the origin; the one at (8, 0, 0) is missing.
Domain someLeaves()
{
    auto topology = std::make_shared<openvdb::MaskTree>();
    for (const Coord& at : openvdb::CoordBBox(Coord(-3), Coord(3))) {
        if (at != Coord(1, 0, 0)) topology->setValueOn(Coord(8 * at[0], 8 * at[1], 8 * at[2]));
    }
    return Domain(topology);
}

Int8 lane0(int x)
{
    return Int8{x, 0, 0, 0, 0, 0, 0, 0};
}

TEST(LeafWindow, FindsTheLeavesThatTheDomainFinds)
{
    const Domain domain = someLeaves();
    for (const Coord& origin : {Coord(0, 0, 0), Coord(-8, 16, 0), Coord(24, 24, 24)}) {
        const LeafWindow window(domain, origin);
        std::set<int> slots;
        for (const Coord& step : openvdb::CoordBBox(Coord(-8), Coord(15))) {
            const Coord at = origin + step;
            const int slot = window.slots(lane0(at[0]), lane0(at[1]), lane0(at[2]))[0];
            ASSERT_EQ(window.leaves[std::size_t(slot)], domain.findLeaf(Int4{at[0], at[1], at[2], 0})) << at;
            slots.insert(slot);
        }
        EXPECT_EQ(slots.size(), 27u);
        EXPECT_EQ(*slots.rbegin(), 26);
        EXPECT_EQ(window.slots(lane0(origin[0]), lane0(origin[1]), lane0(origin[2]))[0], LeafWindow::kCentre);
        for (const int far : {-9, 16, 1 << 20, -(1 << 30)}) {
            for (int axis = 0; axis < 3; ++axis) {
                Coord at = origin;
                at[axis] += far;
                const Int8 found = window.slots(lane0(at[0]), lane0(at[1]), lane0(at[2]));
                EXPECT_EQ(found[0], LeafWindow::kElsewhere) << at;
            }
        }
    }
    EXPECT_EQ(LeafWindow().slots(Int8{}, Int8{}, Int8{})[0], LeafWindow::kElsewhere);
    EXPECT_EQ(LeafWindow().leaves[LeafWindow::kElsewhere], -1);
}

TEST(WindowVoxel, CodesAreDecoded)
{
    for (const int slot : {0, 13, 26}) {
        for (const Coord& at : {Coord(0, 0, 0), Coord(-1, 9, 7), Coord(7, 7, 7)}) {
            const Int8 codes = WindowVoxel::encode(lane0(slot), lane0(at[0]), lane0(at[1]), lane0(at[2]));
            const WindowVoxel voxel{codes[0]};
            EXPECT_FALSE(voxel.isFar());
            EXPECT_EQ(voxel.slot(), slot);
            EXPECT_EQ(voxel.offset(), Domain::Leaf::coordToOffset(at));
        }
    }
    for (const std::size_t index : {0, 1, 100000}) {
        const WindowVoxel voxel{WindowVoxel::encodeFar(index)};
        EXPECT_TRUE(voxel.isFar());
        EXPECT_EQ(voxel.farIndex(), index);
    }
}

} // namespace
} // namespace vdblic
