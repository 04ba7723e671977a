#include "methods/auflic/literal_lic.h"
#include "methods/test_flow.h"
#include "vdblic/field/refinement.h"
#include "vdblic/methods/flow_texture.h"
#include "vdblic/methods/texture_params.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

void expectEqualTextures(const std::vector<LeafValues<float>>& a, const std::vector<LeafValues<float>>& b)
{
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) {
        ASSERT_EQ(a[k].tree()->activeVoxelCount(), b[k].tree()->activeVoxelCount()) << k;
        std::size_t different = 0;
        for (auto value = a[k].tree()->cbeginValueOn(); value; ++value)
            different += *value != b[k].tree()->getValue(value.getCoord());
        EXPECT_EQ(different, 0u) << "step " << k;
    }
}

class RefinedTexture : public testing::TestWithParam<Refinement> {};

/// A shear flow along x, linear in space and time, whose numbers a float holds exactly: interpolated at a texture's
/// voxels it is what it would be if it were given there. Only voxels next to the rim along y, where there is nothing
/// to interpolate with, and to the outflow differ, and what sharpening and contrast carry from there.
TEST_P(RefinedTexture, EqualsThatOfTheVelocityGivenAtItsVoxels)
{
    const Refinement& refinement = GetParam();
    const int nx = refinement.factors[0], ny = refinement.factors[1], nz = refinement.factors[2];
    const auto along = [](double y, int frame) { return 0.25 + y / 32 + 0.25 * frame; }; // voxels of the velocity
    const openvdb::CoordBBox box({-4, -3, -1}, {29, 28, 2});
    constexpr int kShearSteps = 3;
    const auto coarse = test::makeFrames(
        box, kShearSteps + 1, [&](const Coord& at, int frame) { return Vec3f(float(along(at[1], frame)), 0, 0); });
    const openvdb::CoordBBox fineBox(
        {box.min()[0] * nx, box.min()[1] * ny, box.min()[2] * nz},
        {(box.max()[0] + 1) * nx - 1, (box.max()[1] + 1) * ny - 1, (box.max()[2] + 1) * nz - 1});
    const auto fine = test::makeFrames(fineBox, kShearSteps + 1, [&](const Coord& at, int frame) {
        return Vec3f(float(nx * along((at[1] + 0.5) / ny - 0.5, frame)), 0, 0);
    });
    for (const TextureMethod* const method : {&kAuflic, &kUflic}) {
        TextureParams scatter;
        scatter.method = method;
        scatter.lifeSpan = 3;
        const auto textures = test::streamedTextures(test::refined(coarse, refinement), kShearSteps, scatter);
        const auto expected = test::streamedTextures(fine, kShearSteps, scatter);
        for (std::size_t k = 0; k < textures.size(); ++k) {
            // A step carries less than 10 voxels. Paths that leave at the far end see velocities that are continued
            // from the rim of either grid.
            const int margin = ny + 10 * int(k), farMargin = 10 * int(k + 1);
            std::size_t compared = 0, different = 0;
            for (auto value = expected[k].tree()->cbeginValueOn(); value; ++value) {
                const Coord at = value.getCoord();
                if (at[1] < fineBox.min()[1] + margin || at[1] > fineBox.max()[1] - margin ||
                    at[0] > fineBox.max()[0] - farMargin)
                    continue;
                ++compared;
                different += *value != textures[k].tree()->getValue(at);
            }
            EXPECT_GT(compared, std::size_t(fineBox.volume() / 16)) << k;
            EXPECT_EQ(different, 0u) << "step " << k << " of " << compared;
            EXPECT_EQ(textures[k].tree()->activeVoxelCount(), std::size_t(fineBox.volume()));
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Factors, RefinedTexture,
                         testing::Values(Refinement{{2, 2, 2}}, Refinement{{4, 4, 4}}, Refinement{{1, 4, 2}}),
                         [](const auto& factory) {
                             const auto& factors = factory.param.factors;
                             return std::to_string(factors[0]) + "x" + std::to_string(factors[1]) + "x" +
                                    std::to_string(factors[2]);
                         });

/// A small turning flow off the origin, at negative indices, with a hole that moves.
std::vector<VelocityFrame> smallFlow(int frames)
{
    return test::makeFrames({{-5, 3, -4}, {5, 9, 3}}, frames, [](const Coord& at, int frame) -> std::optional<Vec3f> {
        const float x = float(at[0]), y = float(at[1]) - 6, z = float(at[2]);
        if (std::abs(x + 2 - 0.5f * float(frame)) < 2 && std::abs(y) < 2) return std::nullopt;
        return Vec3f(0.7f - 0.15f * y, 0.15f * x, 0.4f * std::sin(z + 0.5f * float(frame)));
    });
}

TEST(RefinedTextures, EqualTheLiteralForms)
{
    constexpr int kLiteralSteps = 4;
    const auto frames = smallFlow(kLiteralSteps + 1);
    const auto thin = test::makeFrames({{0, 0, 7}, {9, 9, 7}}, kLiteralSteps + 1, [](const Coord& at, int) {
        return Vec3f(0.3f, 0.05f * float(at[0]), 0.1f); // one voxel thick
    });
    for (const Refinement refinement : {Refinement{{2, 2, 2}}, Refinement{{3, 1, 2}}, Refinement{{1, 1, 9}}}) {
        for (const auto& flow : {test::refined(frames, refinement), test::refined(thin, refinement)}) {
            for (const TextureMethod* const method : {&kAuflic2004, &kAuflic}) {
                TextureParams scatter;
                scatter.method = method;
                scatter.lifeSpan = 3;
                expectEqualTextures(test::streamedTextures(flow, kLiteralSteps, scatter),
                                    method == &kAuflic ? test::literalTexturesWithHistory(flow, kLiteralSteps, scatter)
                                                       : test::literalTextures(flow, kLiteralSteps, scatter));
            }
        }
    }
}

TEST(RefinedTextures, AreTheSameForAnyNumberOfThreads)
{
    const auto frames = test::refined(smallFlow(4), {{4, 3, 2}});
    const auto expected = test::streamedTextures(frames, 3, {});
    for (const std::size_t threads : {1, 2, 7}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        expectEqualTextures(test::streamedTextures(frames, 3, {}), expected);
    }
}

} // namespace
} // namespace vdblic
