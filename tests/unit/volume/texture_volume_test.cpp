#include "vdblic/volume/texture_volume.h"

#include "cast/test_scene.h"
#include "vdblic/core/errors.h"
#include "vdblic/field/leaf_voxel.h"
#include "volume/sample_place.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3d;

std::size_t leafAt(const TextureVolume& volume, const Coord& c)
{
    return std::size_t(volume.domain().findLeaf(Int4{c[0], c[1], c[2]}));
}

std::size_t lineAt(const TextureVolume& volume, const Coord& c)
{
    return leafAt(volume, c) * ScalarLeaf::kSize +
           std::size_t(ScalarLeaf::index(LeafVoxel::local(c[0]), LeafVoxel::local(c[1]), LeafVoxel::local(c[2])));
}

bool isShown(const TextureVolume& volume, const Coord& c)
{
    const Int4 voxel{c[0], c[1], c[2]};
    return volume.shown(std::size_t(volume.domain().findLeaf(voxel))).isOn(Domain::offset(voxel));
}

TEST(TextureVolume, HoldsTheGradientOfALinearTextureInWorldSpace)
{
    // A texture that is linear in the world has one gradient everywhere, at the rim as well, for any transform.
    const Vec3d slope(0.3, -0.2, 0.5);
    openvdb::math::Mat4d matrix = openvdb::math::Mat4d::identity();
    matrix.setToRotation(Vec3d(1, -1, 2), 1.1);
    matrix.preScale(Vec3d(0.5, -2, 0.25));
    const auto transform = openvdb::math::Transform::createLinearTransform(matrix);
    const auto grid = boxGrid("density", boxOf(12, 10, 9),
                              [&](const Coord& c) { return float(transform->indexToWorld(c).dot(slope)); });
    grid->setTransform(transform);
    const TextureVolume volume(*grid, *grid);
    const double voxelSize = std::cbrt(0.5 * 2 * 0.25);
    for (const Coord& c : {Coord(0, 0, 0), Coord(11, 9, 8), Coord(5, 0, 8), Coord(7, 8, 7)}) {
        for (int axis = 0; axis < 3; ++axis) {
            const double expected = slope[axis] * voxelSize;
            EXPECT_NEAR(gradientAt(volume, c.asVec3d(), axis), expected, 0.004 * std::abs(expected)) << c << axis;
        }
    }
}

TEST(TextureVolume, KnowsTheRangeOfALeafAndItsNeighbours)
{
    const auto texture = boxGrid("density", boxOf(24, 8, 8), [](const Coord& c) { return c.x() == 16 ? 0.9f : 0.1f; });
    const auto driver = boxGrid("magnitude", boxOf(24, 8, 8), [](const Coord& c) { return float(c.x()); });
    const TextureVolume volume(*texture, *driver);
    ASSERT_EQ(volume.domain().leafCount(), 3u);
    EXPECT_EQ(volume.leafRange(0).lowDriver, 0);
    EXPECT_EQ(volume.leafRange(0).highDriver, 8);
    EXPECT_EQ(volume.leafRange(0).highTexture, 0.1f);
    EXPECT_EQ(volume.leafRange(1).lowDriver, 7);
    EXPECT_EQ(volume.leafRange(1).highDriver, 16);
    // Samples in the outer half of the voxels at the rim may exceed them by half a step.
    EXPECT_FLOAT_EQ(volume.leafRange(1).highTexture, 0.9f + 0.4f);
}

TEST(TextureVolume, BoundsReachToTheFacesOfTheOutermostVoxels)
{
    const auto grid = boxGrid("density", {Coord(-3, 4, 5), Coord(9, 9, 9)}, scattered);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(2.0));
    const TextureVolume volume(*grid, *grid);
    EXPECT_EQ(volume.low(), glm::dvec3(-3.5, 3.5, 4.5));
    EXPECT_EQ(volume.high(), glm::dvec3(9.5, 9.5, 9.5));
    EXPECT_EQ(volume.corners().front(), glm::dvec3(-7, 7, 9));
    EXPECT_EQ(volume.corners().back(), glm::dvec3(19, 19, 19));
}

TEST(TextureVolume, TilesAreVoxels)
{
    const auto grid = openvdb::FloatGrid::create();
    grid->sparseFill({Coord(0), Coord(31)}, 0.25f);
    ASSERT_GT(grid->tree().activeTileCount(), 0u);
    const TextureVolume volume(*grid, *grid);
    EXPECT_EQ(volume.domain().voxelCount(), 32u * 32 * 32);
    EXPECT_EQ(textureAt(volume, {7, 15, 9}), 0.25f);
}

TEST(TextureVolume, LeavesOutWhatIsNoNumber)
{
    const auto grid = boxGrid("density", boxOf(8, 8, 8), [](const Coord&) { return 0.5f; });
    grid->tree().setValueOn({3, 3, 3}, std::nanf(""));
    grid->tree().setValueOn({5, 5, 5}, HUGE_VALF);
    const TextureVolume volume(*grid, *grid);
    EXPECT_EQ(volume.unusableVoxels(), 2u);
    EXPECT_FALSE(isShown(volume, {3, 3, 3}));
    EXPECT_TRUE(isShown(volume, {2, 3, 3}));
    EXPECT_EQ(textureAt(volume, {3, 3, 3}), 0.5f); // the mean of its neighbours
    EXPECT_EQ(gradientAt(volume, {2, 3, 3}, 0), 0);
    EXPECT_EQ(volume.leafRange(0).highTexture, 0.5f);
}

TEST(TextureVolume, ValuesGoOnPastTheRim)
{
    const auto grid = boxGrid("density", boxOf(4, 4, 4), [](const Coord& c) { return float(c.x() + 10 * c.y()); });
    const TextureVolume volume(*grid, *grid);
    constexpr float kUnit = 80 / TextureScale::kUnits;
    EXPECT_NEAR(textureAt(volume, {4, 2, 1}), 24, kUnit);         // beside a face
    EXPECT_NEAR(textureAt(volume, {4, 4, 1}), 44, kUnit);         // beside an edge
    EXPECT_NEAR(textureAt(volume, {4, 4, 4}), 44, kUnit);         // beside a corner
    EXPECT_NEAR(textureAt(volume, {5, 5, 5}), 55, kUnit);         // another voxel on
    EXPECT_EQ(volume.records(0)[TextureLeaf::index(6, 6, 6)], 0); // farther off nothing is known
    EXPECT_FALSE(isShown(volume, {4, 2, 1}));
}

TEST(TextureVolume, CubicConvolutionReproducesAParabola)
{
    const auto parabola = [](const Vec3d& p) { return 0.5 * p.x() * p.x() - p.y() * p.y() + p.x() + 2 * p.z(); };
    const auto grid =
        boxGrid("density", boxOf(20, 12, 12), [&](const Coord& c) { return float(parabola(c.asVec3d())); });
    const TextureVolume volume(*grid, *grid);
    const double unit = 400 / TextureScale::kUnits;
    for (const Vec3d& at : {Vec3d(4.5, 4.25, 3), Vec3d(7.75, 7.5, 7.5), Vec3d(8.25, 8, 8.1), Vec3d(15.5, 3.5, 8.5)}) {
        const SamplePlace place(volume, at);
        const Float8 cubic = volume.texture().cubicAt(place.leaf, Cells(place.position));
        EXPECT_NEAR(cubic[0], parabola(at), unit) << at;
    }
    EXPECT_GT(std::abs(textureAt(volume, {4.5, 4.5, 3}) - parabola({4.5, 4.5, 3})), 0.1); // as linear does not
}

TEST(TextureVolume, LinesLieAlongTheDirectionOfLeastChange)
{
    const Vec3d along = Vec3d(2, 1, -1).unit();
    const Vec3d across = along.cross(Vec3d(0, 0, 1)).unit(), other = along.cross(across);
    const auto grid = boxGrid("density", boxOf(20, 20, 20), [&](const Coord& c) {
        return float(0.5 + 0.25 * std::sin(c.asVec3d().dot(across)) + 0.25 * std::cos(1.3 * c.asVec3d().dot(other)));
    });
    TextureVolume volume(*grid, *grid);
    EXPECT_EQ(volume.lines(), nullptr);
    volume.addLines();
    for (const Coord& c : {Coord(5, 6, 7), Coord(8, 9, 15), Coord(12, 3, 9), Coord(16, 10, 10)}) {
        double m[6];
        for (int k = 0; k < 6; ++k)
            m[k] = double(__builtin_bit_cast(float, unsigned(volume.lines()[lineAt(volume, c)].values[k]) << 16));
        EXPECT_NEAR(m[0] + m[1] + m[2], 1, 0.01);
        const double squareCosine =
            m[0] * along[0] * along[0] + m[1] * along[1] * along[1] + m[2] * along[2] * along[2] +
            2 * (m[3] * along[0] * along[1] + m[4] * along[0] * along[2] + m[5] * along[1] * along[2]);
        EXPECT_GT(squareCosine, 0.97) << c;
    }
}

TEST(TextureVolume, LinesAroundALeafAreItsNeighboursOrItsLast)
{
    const auto grid = boxGrid("density", boxOf(16, 16, 8), scattered); // two by two leaves, and nothing around them
    TextureVolume volume(*grid, *grid);
    volume.addLines();
    const auto sameLine = [&](std::size_t a, const Coord& voxel) {
        const LineRecord &first = volume.lines()[a], &second = volume.lines()[lineAt(volume, voxel)];
        return std::equal(first.values, first.values + 8, second.values);
    };
    const auto leaf = std::size_t(volume.domain().findLeaf(Int4{0, 8, 0}));
    for (int x = -1; x <= 8; ++x) {
        for (int y = -1; y <= 8; ++y) {
            for (int z = -1; z <= 8; ++z) {
                const std::size_t record = leaf * ScalarLeaf::kSize + std::size_t(ScalarLeaf::index(x, y, z));
                // Without a neighbouring leaf the padding is the nearest voxel of this leaf.
                const bool there = x >= 0 && y < 8 && z >= 0 && z < 8;
                const Coord expected = there ? Coord(x, 8 + y, z)
                                             : Coord(std::clamp(x, 0, 7), 8 + std::clamp(y, 0, 7), std::clamp(z, 0, 7));
                EXPECT_TRUE(sameLine(record, expected)) << x << " " << y << " " << z;
            }
        }
    }
}

TEST(TextureVolume, ShowsWhatACutLeaves)
{
    const auto grid = boxGrid("density", boxOf(20, 8, 8), scattered);
    TextureVolume volume(*grid, *grid);
    auto kept = std::make_shared<openvdb::MaskTree>();
    kept->fill({Coord(3, 0, 0), Coord(11, 7, 7)}, true);
    volume.cut(Domain(kept));
    EXPECT_FALSE(isShown(volume, {2, 1, 1}));
    EXPECT_TRUE(isShown(volume, {3, 1, 1}));
    EXPECT_TRUE(isShown(volume, {11, 7, 7}));
    EXPECT_FALSE(isShown(volume, {12, 7, 7}));
    EXPECT_FALSE(isShown(volume, {17, 7, 7})); // its leaf has no voxel in the other domain
    EXPECT_EQ(volume.samples().texture.size(), 9u * 8 * 8);
}

TEST(TextureVolume, RefusesTransformsItCannotRender)
{
    const auto grid = boxGrid("fog", boxOf(4, 4, 4), scattered);
    const auto other = grid->deepCopy();
    other->setName("speed");
    other->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    try {
        const TextureVolume volume(*grid, *other);
        FAIL() << "two transforms were taken";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("speed"), std::string::npos) << error.what();
    }
    const auto far = grid->deepCopy();
    far->setTransform(openvdb::math::Transform::createLinearTransform(1e17));
    try {
        const TextureVolume volume(*far, *far);
        FAIL() << "a box of 4e17 was taken";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("fog: its voxels reach to 3.5e+17"), std::string::npos)
            << error.what();
    }
    grid->setTransform(
        openvdb::math::Transform::createFrustumTransform(openvdb::BBoxd(Vec3d(0), Vec3d(9)), 0.5, 10, 0.1));
    try {
        const TextureVolume volume(*grid, *grid);
        FAIL() << "a frustum was taken";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("fog"), std::string::npos) << error.what();
    }
}

/// The chosen voxels' numbers: values from 0 on in the order of boxGrid(), as the scalar has them. Those of the texture
/// are rounded, to a share of their leaf's range.
std::vector<float> sortedSamples(const TextureVolume& volume)
{
    const VolumeSamples samples = volume.samples();
    std::vector<float> values = samples.driver;
    EXPECT_EQ(samples.texture.size(), values.size());
    const double rounding = (volume.high().x - volume.low().x) * (volume.high().y - volume.low().y) *
                            (volume.high().z - volume.low().z) / double(TextureScale::kUnits);
    for (std::size_t i = 0; i < std::min(samples.texture.size(), values.size()); ++i)
        EXPECT_NEAR(samples.texture[i], values[i], rounding);
    std::sort(values.begin(), values.end());
    return values;
}

TEST(TextureVolume, SamplesOfASmallDomainAreAllVoxelsShown)
{
    const auto grid =
        boxGrid("density", boxOf(30, 17, 9), [](const Coord& c) { return float(c.x() * 17 * 9 + c.y() * 9 + c.z()); });
    const std::vector<float> values = sortedSamples(TextureVolume(*grid, *grid));
    ASSERT_EQ(values.size(), 30u * 17 * 9);
    for (std::size_t i = 0; i < values.size(); ++i)
        EXPECT_EQ(values[i], float(i));
}

TEST(TextureVolume, SamplesAreChosenEvenlyByTheirCoordinates)
{
    const openvdb::CoordBBox box = boxOf(160, 80, 80); // four times the samples there can be
    const auto number = [](const Coord& c) { return float((c.x() * 80 + c.y()) * 80 + c.z()); };
    const auto grid = boxGrid("density", box, number);
    const TextureVolume volume(*grid, *grid);
    const std::vector<float> values = sortedSamples(volume);
    EXPECT_NEAR(double(values.size()), 1 << 18, 4 * 512);
    // Each eighth of the domain, along each axis, has its share; neighbours are chosen independently.
    std::array<double, 8> shares[3]{};
    double pairs = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const int n = int(values[i]), c[] = {n / 6400, n / 80 % 80, n % 80};
        for (int axis = 0; axis < 3; ++axis)
            shares[axis][std::size_t(c[axis] / (axis == 0 ? 20 : 10))] += 8.0 / double(values.size());
        pairs += i > 0 && values[i] == values[i - 1] + 1;
    }
    for (const auto& along : shares) {
        for (const double share : along)
            EXPECT_NEAR(share, 1, 0.03);
    }
    EXPECT_NEAR(pairs / double(values.size()), double(values.size()) / (160 * 80 * 80), 0.01);
    // What is cut away leaves the choice among the others as it was.
    TextureVolume half(*grid, *grid);
    auto kept = std::make_shared<openvdb::MaskTree>();
    kept->fill({Coord(0), Coord(79, 79, 79)}, true);
    half.cut(Domain(kept));
    const auto middle = std::lower_bound(values.begin(), values.end(), 80.0f * 80 * 80);
    EXPECT_EQ(sortedSamples(half), std::vector<float>(values.begin(), middle));
}

TEST(TextureVolume, ForOneLookMakesTheSamePicture)
{
    // The look hides a part of the leaves: those in which the driver, which rises along x, is low.
    const auto texture = boxGrid("density", boxOf(48, 24, 24), scattered);
    const auto driver = boxGrid("magnitude", boxOf(48, 24, 24), [](const Coord& c) { return float(c.x()) / 48; });
    const auto colors = boxGrid("speed", boxOf(48, 24, 24), [](const Coord& c) { return float(c.y()) / 24; });
    Look look = fullLook();
    look.halo.strength = 1;
    TextureVolume whole(*texture, *driver), part(*texture, *driver, glm::dvec3(1), {.look = &look});
    const Camera camera = cameraAlong(whole, {1, 0.4, -0.3}, 200, 18, {40, 40});
    const Image image = castRays(whole, look, camera, {.layers = true});
    EXPECT_GT(image.at(20, 20).a, 0.1f);
    EXPECT_EQ(difference(image, castRays(part, look, camera, {.layers = true})), 0);
    for (TextureVolume* volume : {&whole, &part})
        volume->addColors(*texture, *colors);
    EXPECT_EQ(difference(castRays(whole, look, camera, {}), castRays(part, look, camera, {})), 0);
}

} // namespace
} // namespace vdblic
