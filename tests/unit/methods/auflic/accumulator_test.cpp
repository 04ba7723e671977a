#include "vdblic/methods/auflic/accumulator.h"

#include "methods/test_flow.h"
#include "vdblic/lic/hits.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>

namespace vdblic {
namespace {

TEST(Accumulator, IsATreeOfTheOpenLeaves)
{
    const auto frames = test::unsteadyFlowWithHole(1);
    const Domain& domain = *frames[0].domain.texture;
    const openvdb::Coord hole(2, 12, 0), outside(-7, 12, 0); // the second is in a leaf of the domain
    ASSERT_FALSE(domain.topology().isValueOn(hole) || domain.topology().isValueOn(outside));
    Accumulator accumulator(domain);
    EXPECT_EQ(accumulator.tree().leafCount(), 0u);
    accumulator.open(domain.own());
    EXPECT_EQ(accumulator.tree().leafCount(), domain.leafCount());
    EXPECT_TRUE(accumulator.tree().hasSameTopology(domain.topology()));
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf) {
        const auto* node = accumulator.tree().probeConstLeaf(domain.origin(leaf));
        ASSERT_EQ(accumulator[leaf], node->buffer().data());
        for (auto word = node->cbeginValueAll(); word; ++word)
            ASSERT_EQ(*word, word.isValueOn() ? 0 : Hits::kOutside);
    }
    const openvdb::Coord inside(10, 12, 0);
    const auto leaf = std::size_t(domain.findLeaf(inside));
    accumulator[leaf][Domain::offset(inside)] += 5;
    EXPECT_EQ(accumulator.tree().getValue(inside), 5);
    EXPECT_EQ(accumulator.tree().getValue(hole), Hits::kOutside);
    EXPECT_EQ(accumulator.tree().getValue(outside), Hits::kOutside);
    EXPECT_EQ(accumulator.tree().getValue(openvdb::Coord(900, 0, 0)), Hits::kOutside);

    accumulator.close(domain.own().subspan(leaf, 1));
    EXPECT_EQ(accumulator[leaf], nullptr);
    EXPECT_EQ(accumulator.tree().getValue(inside), Hits::kOutside);
    EXPECT_EQ(accumulator.tree().leafCount(), domain.leafCount() - 1);
    accumulator.open(domain.own().subspan(leaf, 1));
    EXPECT_EQ(accumulator.tree().getValue(inside), 0);
    accumulator.close(domain.own());
    EXPECT_EQ(accumulator.tree().leafCount(), 0u);
}

} // namespace
} // namespace vdblic
