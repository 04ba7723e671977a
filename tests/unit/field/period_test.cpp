#include "vdblic/field/period_position.h"

#include "vdblic/field/bricks.h"
#include "vdblic/field/domain.h"
#include "vdblic/field/neighbourhood_grid.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;

const Period kAlongX{{-8, 0, 0}, {24, 0, 0}};

TEST(Period, VoxelsOfImagesAreThoseOfTheBox)
{
    for (int turn = -3; turn <= 3; ++turn) {
        for (int x = -8; x < 16; ++x)
            EXPECT_EQ(kAlongX.wrapped(Coord(x + 24 * turn, 40 * turn, 5)), Coord(x, 40 * turn, 5));
    }
    EXPECT_EQ(Period{}.wrapped(Coord(7, -9, 1 << 20)), Coord(7, -9, 1 << 20));
    const int most = std::numeric_limits<int>::max(), least = std::numeric_limits<int>::min();
    for (const int far : {most, least}) {
        const int x = kAlongX.wrapped(Coord(far, 0, 0))[0];
        EXPECT_TRUE(x >= -8 && x < 16) << x;
        EXPECT_EQ((x - std::int64_t(far)) % 24, 0);
    }
}

TEST(Period, PositionsGoToVoxelsOfTheBox)
{
    const auto wrapped = [](float x) { return vdblic::wrapped(kAlongX, Float4{x, 99, 0, 0}); };
    for (float x = -8.5f; x < 15.5f; x += 0.125f) {
        EXPECT_EQ(wrapped(x)[0], x);
        EXPECT_EQ(wrapped(x + 48)[0], x);
        EXPECT_EQ(wrapped(x - 24)[0], x);
        EXPECT_EQ(wrapped(x)[1], 99);
    }
    // Next to the seam, and so far away that floats have no fractions.
    for (const float at : {-8.5f, 15.5f, 39.5f, -32.5f, 1e7f, 1e20f, -1e20f, std::numeric_limits<float>::infinity()}) {
        for (const float near : {at, std::nextafter(at, -1e30f), std::nextafter(at, 1e30f)}) {
            const Int4 voxel = voxelOf(wrapped(near));
            EXPECT_TRUE(voxel[0] >= -8 && voxel[0] < 16) << near << " " << voxel[0];
        }
    }
}

TEST(Period, BoxesSeeImages)
{
    const CoordBBox box(Coord(16, 0, 0), Coord(23, 7, 7)); // the image of -8 to -1
    EXPECT_TRUE(kAlongX.isSeenIn(box, Coord(-8, 0, 0)));
    EXPECT_FALSE(kAlongX.isSeenIn(box, Coord(0, 0, 0)));
    EXPECT_FALSE(kAlongX.isSeenIn(box, Coord(-8, 8, 0)));
    EXPECT_TRUE(kAlongX.overlap(box, CoordBBox(Coord(-4), Coord(-3, 0, 0))));
    EXPECT_FALSE(kAlongX.overlap(box, CoordBBox(Coord(0), Coord(8))));
    EXPECT_FALSE(kAlongX.overlap(box, CoordBBox(Coord(-4, 8, 0), Coord(-3, 9, 0))));
    for (const Coord& first : {Coord(23, 7, 7), Coord(24, 7, 7), Coord(-8, 0, 0)}) {
        const CoordBBox other(first, first);
        EXPECT_EQ(Period{}.overlap(box, other), box.isInside(first));
        EXPECT_EQ(Period{}.overlap(other, box), box.isInside(first));
        EXPECT_EQ(Period{}.isSeenIn(box, first), box.isInside(first));
    }
}

TEST(Period, ADomainFindsTheLeavesOfImages)
{
    const auto topology = std::make_shared<openvdb::MaskTree>();
    topology->denseFill(CoordBBox(Coord(-8, 0, 0), Coord(15, 7, 7)), true);
    const Domain open(topology), periodic(topology, 1, kAlongX);
    for (int x = -8; x < 16; ++x) {
        EXPECT_EQ(periodic.findLeaf(Coord(x + 24, 3, 3)), open.findLeaf(Coord(x, 3, 3)));
        EXPECT_EQ(open.findLeaf(Coord(x + 24, 3, 3)), -1);
        EXPECT_EQ(periodic.findLeaf(Coord(x, 8, 3)), -1);
    }
}

TEST(Period, NeighboursAcrossTheSeamAreNear)
{
    const std::array<float, 3> spacing{4, 4, 4};
    NeighbourhoodGrid grid(spacing, kAlongX);
    grid.add({-8, 0, 0}, 0);
    const auto any = [](std::uint32_t) { return true; };
    const NeighbourhoodGrid::Look look(grid);
    EXPECT_TRUE(look.anyWithin({15, 0, 0}, 0.5f, any));
    EXPECT_FALSE(look.anyWithin({13, 0, 0}, 0.5f, any));
    EXPECT_FALSE(look.anyWithin({15, 3, 0}, 0.5f, any));
}

} // namespace
} // namespace vdblic
