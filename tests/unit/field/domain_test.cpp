#include "vdblic/field/domain.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/box_domain.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <string>

namespace vdblic {
namespace {

/// Voxels strewn over a box about the origin, some in clumps.
openvdb::MaskTree::Ptr strewnVoxels(int reach, int count)
{
    auto tree = std::make_shared<openvdb::MaskTree>();
    std::mt19937 random(7);
    std::uniform_int_distribution<int> coordinate(-reach, reach - 1);
    for (int i = 0; i < count; ++i) {
        const openvdb::Coord voxel(coordinate(random), coordinate(random), coordinate(random));
        tree->setValueOn(voxel);
        tree->setValueOn(voxel.offsetBy(5, -3, 1));
    }
    return tree;
}

TEST(Domain, NumbersLeavesAsEveryTreeOfItsTopologyVisitsThem)
{
    const auto topology = strewnVoxels(300, 2000);
    topology->fill(openvdb::CoordBBox(openvdb::Coord(-140), openvdb::Coord(20)), true); // with tiles
    const Domain domain(topology);
    const LeafValues<float> values(domain, 3);
    ASSERT_EQ(values.tree()->leafCount(), domain.leafCount());
    EXPECT_EQ(values.tree()->activeVoxelCount(), domain.voxelCount());
    EXPECT_TRUE(values.tree()->hasSameTopology(domain.topology()));
    std::size_t number = 0;
    for (auto leaf = values.tree()->cbeginLeaf(); leaf; ++leaf, ++number) {
        ASSERT_EQ(leaf->origin(), domain.origin(number));
        ASSERT_EQ(leaf->getValueMask(), domain.mask(number));
        ASSERT_EQ(leaf->buffer().data(), values[number]);
        ASSERT_EQ(values[number][511], 3);
    }
}

TEST(Domain, FindsTheLeavesThatTheTreeFinds)
{
    for (const int reach : {20, 150, 2000}) {
        const Domain domain(strewnVoxels(reach, 300));
        std::mt19937 random(11);
        std::uniform_int_distribution<int> coordinate(-reach - 30, reach + 30);
        int found = 0;
        const auto expectSame = [&](const openvdb::Coord& voxel) {
            const auto* leaf = domain.topology().probeConstLeaf(voxel);
            const int number = domain.findLeaf(voxel);
            ASSERT_EQ(number >= 0, leaf != nullptr) << voxel;
            if (!leaf) return;
            ++found;
            ASSERT_EQ(domain.origin(std::size_t(number)), leaf->origin()) << voxel;
            ASSERT_EQ(domain.isActive(number, Domain::offset(voxel)), leaf->isValueOn(voxel)) << voxel;
            ASSERT_EQ(Domain::offset(voxel), Domain::Leaf::coordToOffset(voxel)) << voxel;
        };
        for (int i = 0; i < 20000; ++i)
            expectSame({coordinate(random), coordinate(random), coordinate(random)});
        for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf) {
            for (const int corner : {-1, 0, 7, 8})
                expectSame(domain.origin(leaf).offsetBy(corner, 7 - corner, corner));
        }
        EXPECT_GT(found, 500);
    }
}

TEST(Domain, FindsNothingFarAway)
{
    const Domain domain(strewnVoxels(20, 50));
    for (const int far : {1000, -1000, 1 << 20, -(1 << 20), 1 << 30, -(1 << 30)}) {
        EXPECT_EQ(domain.findLeaf(openvdb::Coord(far, 0, 0)), -1);
        EXPECT_EQ(domain.findLeaf(openvdb::Coord(0, far, 0)), -1);
        EXPECT_EQ(domain.findLeaf(openvdb::Coord(0, 0, far)), -1);
    }
}

TEST(Domain, ExpandsTiles)
{
    auto topology = std::make_shared<openvdb::MaskTree>();
    topology->addTile(1, openvdb::Coord(-8, 0, 128), true, true);       // one leaf's worth
    topology->addTile(2, openvdb::Coord(-128, -128, -128), true, true); // 16³ leaves
    const Domain domain(topology);
    EXPECT_EQ(domain.leafCount(), 4097u);
    EXPECT_EQ(domain.voxelCount(), 4097u * 512u);
    const int leaf = domain.findLeaf(openvdb::Coord(-3, 4, 130));
    ASSERT_GE(leaf, 0);
    EXPECT_EQ(domain.origin(std::size_t(leaf)), openvdb::Coord(-8, 0, 128));
    EXPECT_TRUE(domain.mask(std::size_t(leaf)).isOn());
}

TEST(Domain, LeavesWithoutActiveVoxelsAreNone)
{
    auto topology = strewnVoxels(20, 50);
    const std::size_t leaves = topology->leafCount();
    topology->touchLeaf(openvdb::Coord(400, 400, 400));
    topology->touchLeaf(openvdb::Coord(-400, 0, 0));
    const Domain domain(topology);
    EXPECT_EQ(domain.leafCount(), leaves);
    EXPECT_EQ(domain.findLeaf(openvdb::Coord(401, 401, 401)), -1);
}

TEST(Domain, MayBeEmpty)
{
    auto touched = std::make_shared<openvdb::MaskTree>();
    touched->touchLeaf(openvdb::Coord(0));
    for (const auto& topology : {std::make_shared<openvdb::MaskTree>(), touched}) {
        const Domain domain(topology);
        EXPECT_EQ(domain.leafCount(), 0u);
        EXPECT_EQ(domain.voxelCount(), 0u);
        EXPECT_EQ(domain.findLeaf(openvdb::Coord(0, 0, 0)), -1);
        EXPECT_TRUE(LeafValues<float>(domain, 0).tree()->empty());
    }
}

TEST(Domain, RefusesIslandsThatAreFarAway)
{
    const auto messageFor = [](const openvdb::Coord& island) -> std::string {
        auto topology = std::make_shared<openvdb::MaskTree>();
        topology->setValueOn(openvdb::Coord(0));
        topology->setValueOn(island);
        try {
            const Domain domain(topology);
            return {};
        } catch (const InputError& error) {
            return error.what();
        }
    };
    EXPECT_EQ(messageFor({131071, 0, 0}), "");
    EXPECT_EQ(messageFor({0, 0, -131072}), "");
    EXPECT_NE(messageFor({131072, 0, 0}).find("along axis 0"), std::string::npos);
    EXPECT_NE(messageFor({0, -131073, 0}).find("along axis 1"), std::string::npos);
    EXPECT_NE(messageFor({0, 0, 2000000000}).find("move the grid's origin"), std::string::npos);
    // Within reach along each axis, yet too much space between them.
    EXPECT_NE(messageFor({100000, 100000, 100000}).find("blocks of 128 voxels"), std::string::npos);
}

TEST(BoxDomain, HoldsExactlyTheBox)
{
    const auto domain = boxDomain({9, 16, 130});
    EXPECT_EQ(domain->voxelCount(), 9u * 16u * 130u);
    EXPECT_EQ(domain->leafCount(), 2u * 2u * 17u);
    openvdb::CoordBBox box;
    EXPECT_TRUE(domain->topology().evalActiveVoxelBoundingBox(box));
    EXPECT_EQ(box, openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(8, 15, 129)));
    EXPECT_EQ(boxDomain({1, 1, 1})->voxelCount(), 1u);
}

TEST(BoxDomain, RefusesSizesThatAreNone)
{
    for (const BoxSize& size :
         {BoxSize{0, 1, 1}, BoxSize{1, -1, 1}, BoxSize{1, 1, 100001}, BoxSize{2000, 2000, 2000}}) {
        EXPECT_THROW(checkBoxSize(size), ParameterError) << size[0] << " " << size[1] << " " << size[2];
    }
    EXPECT_NO_THROW(checkBoxSize({2000, 2000, 1000}));
    EXPECT_NO_THROW(checkBoxSize({100000, 40000, 1}));
}

} // namespace
} // namespace vdblic
