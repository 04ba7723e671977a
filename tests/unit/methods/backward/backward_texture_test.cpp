#include "vdblic/methods/backward/backward_texture.h"

#include "methods/test_flow.h"
#include "temporary_folder.h"
#include "vdblic/core/errors.h"
#include "vdblic/field/slabs.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/methods/ibfv/ibfv.h"
#include "vdblic/methods/lea/lea.h"
#include "vdblic/methods/registry.h"
#include "vdblic/methods/ufac/ufac.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

std::unique_ptr<FlowTexture> makeLookingBack(const TextureMethod* method)
{
    TextureParams params;
    params.method = method;
    return makeFlowTexture({params, {}, {}}, {NoiseField(7)});
}

std::vector<LeafValues<float>> lookingBack(const std::vector<VelocityFrame>& frames, const TextureMethod* method)
{
    const auto texture = makeLookingBack(method);
    std::vector<LeafValues<float>> made;
    for (std::size_t k = 0; k + 1 < frames.size(); ++k)
        made.push_back(texture->advance(test::stepFrom(frames, k)).texture);
    return made;
}

bool areEqual(const LeafValues<float>& a, const LeafValues<float>& b, const Domain& domain)
{
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf) {
        if (!std::equal(a[leaf], a[leaf] + Domain::kLeafVoxels, b[leaf])) return false;
    }
    return true;
}

class LooksBack : public testing::TestWithParam<const TextureMethod*> {};

TEST_P(LooksBack, AndIsTheSameForAnyThreads)
{
    const auto frames = test::unsteadyFlowWithHole(6);
    std::vector<std::vector<LeafValues<float>>> made;
    for (const std::size_t threads : {1, 2, 5}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        made.push_back(lookingBack(frames, GetParam()));
    }
    for (std::size_t k = 0; k < made[0].size(); ++k) {
        EXPECT_TRUE(areEqual(made[0][k], made[1][k], *frames[k].domain.texture));
        EXPECT_TRUE(areEqual(made[0][k], made[2][k], *frames[k].domain.texture));
    }
}

TEST_P(LooksBack, AndGivesEveryVoxelAValueBetweenBlackAndWhite)
{
    for (const openvdb::CoordBBox& box :
         {openvdb::CoordBBox({7, 7, 7}, {7, 7, 7}), openvdb::CoordBBox({-9, 0, 4}, {20, 15, 4}),
          openvdb::CoordBBox({1, 1, 1}, {0, 0, 0}), openvdb::CoordBBox({-30, -3, 0}, {41, 9, 9})}) {
        const auto frames = test::makeFrames(box, 6, [](const Coord& at, int frame) {
            return Vec3f(30 * std::sin(float(at[1] + frame)), 0.2f, float(at[0]) * 0.1f);
        });
        const LeafValues<float> texture = lookingBack(frames, GetParam()).back();
        EXPECT_EQ(texture.tree()->activeVoxelCount(), box.empty() ? 0 : box.volume());
        for (auto value = texture.tree()->cbeginValueOn(); value; ++value)
            ASSERT_TRUE(*value >= 0 && *value <= 1) << *value;
    }
}

TEST_P(LooksBack, AndStaysBetweenBlackAndWhiteHoweverFastTheFlowIs)
{
    for (const float speed : {1e5f, 1e10f, 1e20f, 1e30f, 3e38f}) {
        const auto frames =
            test::makeFrames(openvdb::CoordBBox({0, 0, 0}, {9, 8, 7}), 4, [&](const Coord& at, int frame) {
                return Vec3f(at[0] % 2 == 0 ? speed : -speed, frame % 2 == 0 ? speed : 0, at[2] < 4 ? 1 : speed);
            });
        const LeafValues<float> texture = lookingBack(frames, GetParam()).back();
        for (auto value = texture.tree()->cbeginValueOn(); value; ++value)
            ASSERT_TRUE(*value >= 0 && *value <= 1) << *value << " at " << speed;
    }
}

TEST_P(LooksBack, AndIsTheSameWhetherTheVelocityIsHeldInPartsOrWhole)
{
    const auto frames = test::makeFrames({{0, 0, 0}, {399, 63, 63}}, 3, [](const Coord& at, int frame) {
        const float x = 0.1f * float(at[0]), y = 0.2f * float(at[1]), t = 0.5f * float(frame);
        return Vec3f(1.5f + std::sin(y + t), std::cos(x - t), std::sin(x + y));
    });
    ASSERT_GT(Slabs(*frames[0].domain.texture).size(), 2u);
    auto fast = frames; // a fast voxel outside the domain raises the bound of the reach
    for (VelocityFrame& frame : fast) {
        const auto grid = frame.values->deepCopy();
        grid->tree().setValue(Coord(-1000), Vec3f(1e4f));
        frame.values = grid;
    }
    const auto parts = lookingBack(frames, GetParam()), whole = lookingBack(fast, GetParam());
    for (std::size_t k = 0; k < parts.size(); ++k)
        EXPECT_TRUE(areEqual(parts[k], whole[k], *frames[k].domain.texture)) << k;
}

TEST_P(LooksBack, AndPassesOverAFrameWithoutVoxels)
{
    auto frames = test::unsteadyFlowWithHole(8);
    frames[4] = test::makeFrames({{1, 1, 1}, {0, 0, 0}}, 1, [](auto&, int) { return Vec3f(0); })[0];
    const auto textures = lookingBack(frames, GetParam());
    EXPECT_EQ(textures[4].tree()->activeVoxelCount(), 0u);
    EXPECT_EQ(textures[6].tree()->activeVoxelCount(), frames[6].domain.texture->voxelCount());
}

TEST_P(LooksBack, AndGoesOnToTheBitFromASavedState)
{
    const auto frames = test::unsteadyFlowWithHole(7); // every frame has another domain
    const auto expected = lookingBack(frames, GetParam());
    for (const std::size_t saved : {1, 2, 5}) {
        const auto before = makeLookingBack(GetParam());
        for (std::size_t k = 0; k < saved; ++k)
            (void)before->advance(test::stepFrom(frames, k));
        const TemporaryFolder folder;
        const openvdb::GridPtrVec grids = test::memoryOf(*before).save(0).grids;
        writeVdb(folder / "state.vdb", openvdb::GridCPtrVec(grids.begin(), grids.end()), {});
        const auto source = [&, next = true]() mutable {
            return std::exchange(next, false) ? std::optional(readVdb(folder / "state.vdb")) : std::nullopt;
        };
        const auto after = makeLookingBack(GetParam());
        test::memoryOf(*after).restore(saved, 1, frames[saved].domain.texture, source);
        for (std::size_t k = saved; k < expected.size(); ++k) {
            EXPECT_TRUE(
                areEqual(after->advance(test::stepFrom(frames, k)).texture, expected[k], *frames[k].domain.texture))
                << "step " << k << " after " << saved;
        }
        EXPECT_THROW(
            test::memoryOf(*makeLookingBack(GetParam())).restore(saved, 1, frames[saved + 1].domain.texture, source),
            InputError);
    }
}

INSTANTIATE_TEST_SUITE_P(Methods, LooksBack, testing::Values(&kIbfv, &kLea, &kUfac));

} // namespace
} // namespace vdblic
