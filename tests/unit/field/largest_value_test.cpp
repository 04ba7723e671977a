#include "vdblic/field/largest_value.h"

#include "vdblic/field/velocity_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

/// A tree with a full leaf, leaves with few active voxels, and inactive values larger than all others.
openvdb::Vec3STree variedTree()
{
    openvdb::Vec3STree tree(Vec3f(100));
    const auto valueAt = [](const Coord& at) {
        return Vec3f(float(at[0]), float(-at[1]), float(at[2] - at[0])) * 0.5f;
    };
    for (auto at = openvdb::CoordBBox::createCube(Coord(0), 8).begin(); at; ++at)
        tree.setValue(*at, valueAt(*at));
    for (int i = 0; i < 40; ++i)
        tree.setValue(Coord(-i, 3 * i % 17, 11 * i % 23), valueAt(Coord(-i, 3 * i % 17, 11 * i % 23)));
    return tree;
}

Vec3f plainMagnitude(const openvdb::Vec3STree& tree)
{
    Vec3f most(0);
    for (auto value = tree.cbeginValueOn(); value; ++value) {
        for (int axis = 0; axis < 3; ++axis)
            most[axis] = std::max(most[axis], std::abs((*value)[axis]));
    }
    return most;
}

TEST(LargestValues, AreThoseOfActiveVoxels)
{
    openvdb::Vec3STree tree = variedTree();
    const StoredSpeeds found = largestSpeeds(tree);
    for (int axis = 0; axis < 3; ++axis)
        EXPECT_EQ(found[axis], plainMagnitude(tree)[axis]) << axis;
}

TEST(LargestValues, AreThoseOfTilesToo)
{
    openvdb::Vec3STree tree = variedTree();
    tree.addTile(1, Coord(64, 64, 64), Vec3f(-1, 77, 0), true);
    tree.addTile(1, Coord(128, 64, 64), Vec3f(99), false);
    const StoredSpeeds found = largestSpeeds(tree);
    EXPECT_EQ(found[0], plainMagnitude(tree)[0]);
    EXPECT_EQ(found[1], 77);
}

TEST(LargestValues, WithoutActiveValuesAreZero)
{
    const StoredSpeeds found = largestSpeeds(openvdb::Vec3STree(Vec3f(5)));
    EXPECT_EQ(found[0], 0);
    EXPECT_EQ(found[1], 0);
    EXPECT_EQ(found[2], 0);
}

TEST(LargestValues, OfScalars)
{
    openvdb::FloatTree tree(9.0f);
    tree.setValue({1, 2, 3}, -4);
    tree.setValue({30, 2, 5}, 3);
    const NumberRow found = largestValues(
        tree, [](const NumberRow& row) { return NumberRow{row.numbers < 0 ? -row.numbers : row.numbers}; });
    EXPECT_EQ(largestLane(found.numbers), 4);
}

} // namespace
} // namespace vdblic
