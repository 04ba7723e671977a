#include "vdblic/coherence/sparse_coherence.h"

#include "vdblic/field/velocity_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>

namespace vdblic {
namespace {

using openvdb::Coord;

constexpr int kSide = 48, kSpacing = 8, kTail = 12;

/// Uniform flow along x, in voxels a step.
class Uniform {
  public:
    explicit Uniform(float speed)
    {
        mTree.denseFill(openvdb::CoordBBox(Coord(0), Coord(kSide - 1)), openvdb::Vec3f(speed, 0, 0), true);
        mTree.voxelizeActiveTiles();
        mDomain = std::make_shared<const Domain>(
            std::make_shared<openvdb::MaskTree>(mTree, false, true, openvdb::TopologyCopy()));
        field.build(mDomain, {mTree, openvdb::Mat3d::identity()}, {mTree, openvdb::Mat3d::identity()});
    }
    VelocityField field;

  private:
    openvdb::Vec3STree mTree;
    std::shared_ptr<const Domain> mDomain;
};

/// Streaks along x whose heads are a spacing apart across, and three along.
/// @param shift of them along x  @param every streak that is left out
SparseTexture streaks(int shift, int every = 0)
{
    auto tree = std::make_shared<openvdb::FloatTree>(0.0f);
    int number = 0;
    for (int x = -kSpacing; x < kSide + 2 * kTail; x += 3 * kSpacing) {
        for (int y = kSpacing / 2; y < kSide; y += kSpacing) {
            for (int z = kSpacing / 2; z < kSide; z += kSpacing) {
                if (every > 0 && ++number % every == 0) continue;
                for (int back = 0; back < kTail; ++back) {
                    const Coord voxel(x + shift - back, y, z);
                    if (voxel[0] < 0 || voxel[0] >= kSide) continue;
                    tree->setValue(voxel, 1 - float(back) / kTail);
                }
            }
        }
    }
    auto active = std::make_shared<openvdb::MaskTree>(*tree, false, true, openvdb::TopologyCopy());
    return {tree, std::make_shared<const Domain>(active), {}, std::array<float, 3>{kSpacing, kSpacing, kSpacing}};
}

TEST(SparseCoherence, StreaksThatMoveWithTheFlow)
{
    const Uniform forward(2), backward(-2);
    const SparseTexture now = streaks(0), next = streaks(2);
    const SparseCoherence measured = measureSparse(now, &next, forward.field, &backward.field, {}, 1);
    const SparseFigures& figures = measured.figures;
    EXPECT_EQ(figures.held, double(now.domain->voxelCount()) / (kSide * kSide * kSide));
    EXPECT_GT(figures.rising, 0.9); // but for the heads themselves
    EXPECT_GT(figures.temporal, 0.999);
    EXPECT_EQ(figures.vanishing, 0);
    EXPECT_EQ(figures.appearing, 0);
    EXPECT_EQ(figures.lowApart, 1);
    EXPECT_EQ(figures.medianApart, 1);
    EXPECT_EQ(measured.heads % 36, 0u);
    EXPECT_GT(measured.heads, 0u);
}

TEST(SparseCoherence, AgainstTheFlowValuesFall)
{
    const Uniform flow(-2);
    EXPECT_LT(measureSparse(streaks(0), nullptr, flow.field, nullptr, {}, 1).figures.rising, 0.1);
}

TEST(SparseCoherence, TellsWhatVanishesAndWhatAppears)
{
    const Uniform forward(2), backward(-2);
    const SparseTexture all = streaks(0), fewer = streaks(2, 4);
    const SparseFigures lost = measureSparse(all, &fewer, forward.field, &backward.field, {}, 1).figures;
    EXPECT_NEAR(lost.vanishing, 0.25, 0.05);
    EXPECT_EQ(lost.appearing, 0);
    const SparseTexture before = streaks(0, 4), after = streaks(2);
    const SparseFigures won = measureSparse(before, &after, forward.field, &backward.field, {}, 1).figures;
    EXPECT_EQ(won.vanishing, 0);
    EXPECT_NEAR(won.appearing, 0.25, 0.05);
}

TEST(SparseCoherence, DistancesAreInSpacings)
{
    const Uniform flow(2);
    SparseTexture texture = streaks(0);
    texture.spacing = std::array<float, 3>{2 * kSpacing, 2 * kSpacing, 2 * kSpacing};
    EXPECT_FLOAT_EQ(float(measureSparse(texture, nullptr, flow.field, nullptr, {}, 1).figures.medianApart), 0.5f);
    texture.spacing.reset();
    EXPECT_TRUE(std::isnan(measureSparse(texture, nullptr, flow.field, nullptr, {}, 1).figures.medianApart));
}

TEST(SparseCoherence, OfStillFluidNothingIsKnown)
{
    const Uniform flow(0);
    const SparseCoherence measured = measureSparse(streaks(0), nullptr, flow.field, nullptr, {}, 1);
    EXPECT_EQ(measured.points, 0u);
    EXPECT_TRUE(std::isnan(measured.figures.rising));
}

} // namespace
} // namespace vdblic
