#include "vdblic/field/window_box.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>

namespace vdblic {
namespace {

using openvdb::Coord;

/// The voxels of a box that a rule takes.
Domain voxelsOf(const openvdb::CoordBBox& box, const std::function<bool(const Coord&)>& rule)
{
    auto topology = std::make_shared<openvdb::MaskTree>();
    for (const Coord& at : box) {
        if (rule(at)) topology->setValueOn(at);
    }
    return Domain(topology);
}

/// Compare a box with the voxels of its window one by one.
/// @param isExact whether the window's voxels are a box
void expectTheDomainsVoxels(const Domain& domain, std::size_t leaf, bool isExact)
{
    const Coord origin = domain.origin(leaf);
    const WindowBox box(domain, LeafWindow(domain, origin));
    EXPECT_EQ(box.isExact(), isExact) << origin;
    bool isWindow = true;
    for (const Coord& step : openvdb::CoordBBox(Coord(-8), Coord(15))) {
        const Coord at = origin + step;
        const auto lanes = [&](int axis) { return broadcastInt8(at[axis]); };
        const bool held = box.holds(0, lanes(0))[0] && box.holds(1, lanes(1))[0] && box.holds(2, lanes(2))[0];
        const bool active = domain.topology().isValueOn(at);
        isWindow = isWindow && active;
        if (held || isExact) {
            ASSERT_EQ(held, active) << at;
        }
        bool allActive = true;
        for (const Coord& corner : openvdb::CoordBBox(at, at.offsetBy(1)))
            allActive = allActive && domain.topology().isValueOn(corner);
        const bool cell = box.holdsCell(lanes(0), lanes(1), lanes(2))[0];
        ASSERT_TRUE(allActive || !cell) << at;
    }
    EXPECT_EQ(box.isWindow(), isWindow);
}

TEST(LeafBox, IsAroundTheActiveVoxels)
{
    openvdb::util::NodeMask<3> mask;
    EXPECT_TRUE(LeafBox(mask).spans[0].isEmpty());
    EXPECT_TRUE(LeafBox(mask).isExact);
    mask.setOn(openvdb::Index(LeafVoxel::offset(2, 7, 5)));
    EXPECT_TRUE(LeafBox(mask).isExact);
    mask.setOn(openvdb::Index(LeafVoxel::offset(4, 7, 0)));
    const LeafBox box(mask);
    EXPECT_EQ(box.spans[0], (LeafSpan{2, 4}));
    EXPECT_EQ(box.spans[1], (LeafSpan{7, 7}));
    EXPECT_EQ(box.spans[2], (LeafSpan{0, 5}));
    EXPECT_FALSE(box.isExact);
    mask.setOn();
    EXPECT_TRUE(LeafBox(mask).isFull);
    EXPECT_TRUE(LeafBox(mask).isExact);
}

TEST(WindowBox, IsThatOfABoxOfVoxels)
{
    const openvdb::CoordBBox box(Coord(-3, 0, 5), Coord(30, 8, 31));
    const Domain domain = voxelsOf(box, [](const Coord&) { return true; });
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf)
        expectTheDomainsVoxels(domain, leaf, true);
    const Domain large = voxelsOf({Coord(0), Coord(39)}, [](const Coord&) { return true; });
    expectTheDomainsVoxels(large, std::size_t(large.findLeaf(Int4{16, 16, 16, 0})), true);
}

TEST(WindowBox, HasOnlyFullLeavesWhereVoxelsAreNoBox)
{
    const openvdb::CoordBBox box(Coord(0), Coord(39));
    const Domain hole = voxelsOf(box, [](const Coord& at) { return at != Coord(33, 20, 20); });
    expectTheDomainsVoxels(hole, std::size_t(hole.findLeaf(Int4{32, 16, 16, 0})), false);
    expectTheDomainsVoxels(hole, std::size_t(hole.findLeaf(Int4{24, 16, 16, 0})), false);
    expectTheDomainsVoxels(hole, std::size_t(hole.findLeaf(Int4{16, 16, 16, 0})), true);
    const auto grown = WindowBox(hole, LeafWindow(hole, Coord(24, 16, 16)));
    EXPECT_TRUE(grown.holds(0, broadcastInt8(16))[0]);
    EXPECT_FALSE(grown.holds(0, broadcastInt8(32))[0]);
    // Boxes in every leaf that are none together.
    const Domain steps = voxelsOf({Coord(0), Coord(15)}, [](const Coord& at) { return at[0] < 8 || at[1] < 5; });
    for (std::size_t leaf = 0; leaf < steps.leafCount(); ++leaf)
        expectTheDomainsVoxels(steps, leaf, false);
    const Domain missing = voxelsOf({Coord(0), Coord(15)}, [](const Coord& at) { return at[0] < 8 || at[1] < 8; });
    for (std::size_t leaf = 0; leaf < missing.leafCount(); ++leaf)
        expectTheDomainsVoxels(missing, leaf, false);
}

} // namespace
} // namespace vdblic
