#include "vdblic/cast/ray_caster.h"

#include "cast/test_scene.h"
#include "vdblic/core/errors.h"
#include "vdblic/volume/visible_space.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::Vec3d;

const glm::dvec3 kSlanted = glm::normalize(glm::dvec3(0.7, 0.5, -0.4));

/// Clumps of voxels, far apart, some blocks of leaves empty between them.
openvdb::FloatGrid::Ptr clumps(const std::string& name, const Coord& offset = Coord(0))
{
    auto grid = openvdb::FloatGrid::create();
    grid->setName(name);
    for (const Coord& corner :
         {Coord(-70, -9, 3), Coord(-66, 30, 12), Coord(5, 0, 0), Coord(300, 11, -40), Coord(331, 40, 2)}) {
        const auto part = boxGrid(name, {corner + offset, corner.offsetBy(21, 18, 13) + offset}, scattered);
        grid->tree().merge(part->tree());
    }
    return grid;
}

TEST(RayCaster, AUniformMediumHasTheAnalyticTransmittance)
{
    const auto grid = boxGrid("density", boxOf(40, 30, 20), [](const Coord&) { return 0.5f; });
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.1));
    const TextureVolume volume(*grid, *grid);
    constexpr double kOpacity = 0.03, kLength = 40;
    const Camera camera = cameraAlong(volume, {1, 0, 0}, 1e4, 0.005, {48, 48});
    for (const double step : {0.1, 0.25, 0.5, 1.0, 2.5}) {
        const Image image = castRays(volume, plainLook(kOpacity), camera, {.step = step, .leastTransmittance = 0});
        for (const glm::vec4& pixel : image.pixels) {
            const double depth = std::log(1.0 - pixel.a) / std::log(1 - kOpacity);
            EXPECT_NEAR(depth, kLength, 2e-3) << step; // whatever the step and the samples' shift
            EXPECT_NEAR(pixel.r, pixel.a, 1e-5);       // white, premultiplied
        }
    }
}

TEST(RayCaster, LongStepsReadNothingButTheirSurroundings)
{
    // The scalar rises evenly along the view, by 1 from end to end: its mean is that in the middle, up to the half step
    // by which samples are off.
    constexpr int kLength = 40;
    const auto texture = boxGrid("density", boxOf(kLength, 30, 20), [](const Coord&) { return 0.5f; });
    const auto ramp =
        boxGrid("magnitude", boxOf(kLength, 30, 20), [](const Coord& c) { return (float(c.x()) + 0.5f) / kLength; });
    const TextureVolume volume(*texture, *ramp);
    for (const double side : {-1.0, 1.0}) {
        const Camera camera = cameraAlong(volume, {side, 0.02, 0.01}, 1e4, 0.1, {48, 48});
        for (const double step : {1.5, 2.0, 3.0, 7.0}) {
            const RayCastParams params{.step = step, .leastTransmittance = 0, .layers = true};
            const Image image = castRays(volume, plainLook(1e-3), camera, params);
            for (const PixelLayers& layers : image.layers)
                ASSERT_NEAR(layers.driver, 0.5, (step / 2 + 0.2) / kLength) << step << " " << side;
        }
    }
}

TEST(RayCaster, AnEmptyDomainIsAllBackground)
{
    const auto grid = openvdb::FloatGrid::create();
    const TextureVolume volume(*grid, *grid);
    EXPECT_TRUE(volume.empty());
    const Image image = castRays(volume, plainLook(1), Camera({}, volume.corners(), {20, 10}), {});
    ASSERT_EQ(image.pixels.size(), 200u);
    for (const glm::vec4& pixel : image.pixels)
        EXPECT_EQ(pixel, glm::vec4(0));
}

TEST(RayCaster, AnyNumberOfThreadsGivesTheSamePixels)
{
    const auto grid = clumps("density");
    const TextureVolume volume(*grid, *grid);
    const Camera camera({}, volume.corners(), {150, 70});
    std::vector<Image> images;
    for (const std::size_t threads : {1, 2, 7}) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
        images.push_back(castRays(volume, fullLook(), camera, {}));
    }
    EXPECT_GT(difference(images[0], Image{images[0].size, std::vector<glm::vec4>(images[0].pixels.size())}), 0.1f);
    EXPECT_TRUE(images[0].pixels == images[1].pixels);
    EXPECT_TRUE(images[0].pixels == images[2].pixels);
}

TEST(RayCaster, AVoxelIsSeenWhereTransformAndCameraSay)
{
    openvdb::math::Mat4d matrix = openvdb::math::Mat4d::identity();
    matrix.setToRotation(Vec3d(1, 2, 3), 0.7);
    matrix.preScale(Vec3d(0.5, 0.8, -0.3));
    matrix.postTranslate(Vec3d(10, -20, 5));
    for (const Coord& voxel : {Coord(0, 0, 0), Coord(7, -8, 15), Coord(-1, 16, 3)}) {
        const auto grid = boxGrid("density", {voxel, voxel}, [](const Coord&) { return 1.0f; });
        grid->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
        const TextureVolume volume(*grid, *grid);
        const Vec3d center = grid->indexToWorld(voxel);
        // Far away, so that the middle of the silhouette is the middle of the voxel; off the picture's middle.
        const glm::dvec3 target(center.x() + 0.3, center.y() - 0.2, center.z() + 0.1);
        const Camera camera({.eye = target + glm::dvec3(200, -150, 90), .target = target, .fieldOfView = 0.5},
                            volume.corners(), {200, 120});
        const Image image = castRays(volume, plainLook(0.9), camera, {.step = 0.02});
        glm::dvec3 sum(0);
        for (int y = 0; y < image.size.y; ++y) {
            for (int x = 0; x < image.size.x; ++x) {
                if (image.at(x, y).a > 0) sum += glm::dvec3(x + 0.5, y + 0.5, 1);
            }
        }
        ASSERT_GT(sum.z, 100);
        const glm::dvec4 ndc = camera.worldToNdc() * glm::dvec4(center.x(), center.y(), center.z(), 1);
        EXPECT_NEAR(sum.x / sum.z, ndc.x / ndc.w * image.size.x, 0.2) << voxel;
        EXPECT_NEAR(sum.y / sum.z, ndc.y / ndc.w * image.size.y, 0.2) << voxel;
    }
}

TEST(RayCaster, APictureDependsOnPlacesInTheWorldOnly)
{
    const CoordBBox box({-5, 3, 1}, {14, 20, 12});
    const auto grid = boxGrid("density", box, scattered);
    // The same voxels stored mirrored in x, and turned by a right angle about z, with transforms that undo it.
    const auto mirrored = boxGrid("density", {{-14, 3, 1}, {5, 20, 12}}, [](const Coord& c) {
        return scattered({-c.x(), c.y(), c.z()});
    });
    mirrored->setTransform(openvdb::math::Transform::createLinearTransform(
        openvdb::math::Mat4d(-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1)));
    const auto turned = boxGrid("density", {{3, -14, 1}, {20, 5, 12}}, [](const Coord& c) {
        return scattered({-c.y(), c.x(), c.z()});
    });
    turned->setTransform(openvdb::math::Transform::createLinearTransform(
        openvdb::math::Mat4d(0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1)));

    const TextureVolume volume(*grid, *grid);
    const Camera camera = cameraAlong(volume, kSlanted, 60, 25, {90, 70});
    const Image expected = castRays(volume, fullLook(), camera, {});
    for (const auto& same : {mirrored, turned}) {
        const Image image = castRays(TextureVolume(*same, *same), fullLook(), camera, {});
        EXPECT_LT(difference(image, expected), 2e-3f);
    }
}

TEST(RayCaster, TurningAndScalingVolumeAndCameraChangesNothing)
{
    const auto grid = boxGrid("density", boxOf(20, 16, 12), scattered);
    const TextureVolume volume(*grid, *grid);
    const Image expected = castRays(volume, fullLook(), cameraAlong(volume, kSlanted, 60, 25, {90, 70}), {});

    openvdb::math::Mat4d matrix = openvdb::math::Mat4d::identity();
    matrix.setToRotation(Vec3d(0, 0, 1), 0.6); // about the camera's up
    matrix.postScale(Vec3d(7.3));
    matrix.postTranslate(Vec3d(1000, -500, 33));
    grid->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    const TextureVolume moved(*grid, *grid);
    const Vec3d direction = matrix.transform3x3(Vec3d(kSlanted.x, kSlanted.y, kSlanted.z)) / 7.3;
    const glm::dvec3 along(direction.x(), direction.y(), direction.z());
    const Image image = castRays(moved, fullLook(), cameraAlong(moved, along, 60 * 7.3, 25, {90, 70}), {});
    EXPECT_LT(difference(image, expected), 2e-3f);
}

TEST(RayCaster, AStretchedVolumeIsOneWithThatTransform)
{
    const auto grid = boxGrid("density", boxOf(20, 16, 12), scattered);
    const ClipParams cuts{.planes = {{{8, 8, 6}, {1, 2, 3}}}, .box = std::array{glm::dvec3(2), glm::dvec3(17, 14, 9)}};
    const glm::dvec3 stretch(1, 0.5, 3);
    const TextureVolume stretched(*grid, *grid, stretch);
    const Camera camera = cameraAlong(stretched, kSlanted, 80, 35, {60, 50});
    const Image image = castRays(stretched, fullLook(), camera, {.clip = cuts.stretched(stretch)});

    grid->transform().postScale(Vec3d(1, 0.5, 3));
    const ClipParams same{.planes = {{{8, 4, 18}, {1, 4, 1}}},
                          .box = std::array{glm::dvec3(2, 1, 6), glm::dvec3(17, 7, 27)}};
    EXPECT_LT(difference(image, castRays(TextureVolume(*grid, *grid), fullLook(), camera, {.clip = same})), 1e-4f);
    EXPECT_GT(difference(image, castRays(stretched, fullLook(), camera, {})), 0.1f);
}

TEST(RayCaster, PassingOverEmptySpaceChangesNoPixel)
{
    for (const Coord& offset : {Coord(0), Coord(100'000, -130'000, 70'000)}) { // exact and coarse in single precision
        const auto texture = clumps("density", offset);
        const auto driver = clumps("magnitude", offset);
        for (auto i = driver->beginValueOn(); i; ++i) {
            i.setValue(float(i.getCoord().y() - offset.y() + 9) / 80); // transparent for small y
        }
        const TextureVolume volume(*texture, *driver);
        const Look look = fullLook();
        const std::size_t leaves = volume.domain().leafCount();
        std::size_t hidden = 0;
        for (std::size_t leaf = 0; leaf < leaves; ++leaf)
            hidden += !look.contributes(volume.leafRange(leaf));
        EXPECT_GT(hidden, leaves / 10);
        EXPECT_LT(hidden, leaves);

        const VisibleSpace everything(volume, plainLook(0.5)); // in which nothing is hidden
        const VisibleSpace oneByOne(volume, look, 1);
        for (const glm::dvec3& direction : {kSlanted, glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(-1, 0, 0)}) {
            const Camera camera = cameraAlong(volume, direction, 500, 35, {121, 81}); // one ray runs along the axis
            const Image skipped = castRays(volume, look, camera, {});
            EXPECT_GT(difference(skipped, Image{skipped.size, std::vector<glm::vec4>(skipped.pixels.size())}), 0.05f);
            EXPECT_TRUE(skipped.pixels == castRays(volume, look, camera, {}, oneByOne).pixels);
            // Empty space counts as the largest texture that is hidden: with short steps that is no difference.
            const RayCastParams fine{.step = 0.05};
            const Image finest = castRays(volume, look, camera, fine, everything);
            EXPECT_LT(difference(castRays(volume, look, camera, fine), finest), 0.02f);
        }
    }
}

TEST(RayCaster, EndsARayNoEarlierThanAsked)
{
    const auto grid = boxGrid("density", boxOf(30, 30, 30), scattered);
    const TextureVolume volume(*grid, *grid);
    const Camera camera = cameraAlong(volume, kSlanted, 80, 25, {60, 60});
    const Image whole = castRays(volume, plainLook(0.4), camera, {.leastTransmittance = 0});
    const Image ended = castRays(volume, plainLook(0.4), camera, {.leastTransmittance = 0.01});
    EXPECT_GT(difference(whole, ended), 0.f);
    EXPECT_LT(difference(whole, ended), 0.01f);
}

TEST(RayCaster, SamplesThatAddLittleLoseNoLight)
{
    const auto grid = boxGrid("density", boxOf(40, 40, 40), scattered);
    const TextureVolume volume(*grid, *grid);
    const Camera camera = cameraAlong(volume, kSlanted, 100, 25, {60, 60});
    for (const double opacity : {0.0005, 0.02, 0.4}) {
        const RayCastParams fine{.step = 0.1};
        for (const glm::vec4& pixel : castRays(volume, plainLook(opacity), camera, fine).pixels)
            EXPECT_NEAR(pixel.r, pixel.a, 1e-5); // white, premultiplied
        Look look = fullLook();
        look.transfer = TransferFunction({.opacity = {{0, 0}, {1, opacity}}, .range = std::array{0.0, 1.0}});
        const Image each = castRays(volume, look, camera, {.step = 0.1, .leastTransmittance = 0});
        EXPECT_LT(difference(castRays(volume, look, camera, fine), each), 4 / 256.f); // neighbours are unlike
    }
}

TEST(RayCaster, FacesOfABoxArePlanesAtTheSidesOfItsLastVoxels)
{
    const auto grid = boxGrid("density", boxOf(20, 16, 12), [](const Coord&) { return 1.0f; });
    const TextureVolume volume(*grid, *grid);
    const glm::ivec2 size(90, 70);
    const Camera camera = cameraAlong(volume, kSlanted, 60, 40, size);
    const Image image = castRays(volume, plainLook(1), camera, {});
    const auto hitsBox = [&](double margin, const Ray& ray) {
        double first = 0, last = 1e9;
        const glm::dvec3 least(-0.5 - margin), most(19.5 + margin, 15.5 + margin, 11.5 + margin);
        for (int axis = 0; axis < 3; ++axis) {
            const double a = (least[axis] - ray.origin[axis]) / ray.direction[axis],
                         b = (most[axis] - ray.origin[axis]) / ray.direction[axis];
            first = std::max(first, std::min(a, b));
            last = std::min(last, std::max(a, b));
        }
        return first < last;
    };
    int rim = 0, inside = 0;
    for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
            const Ray ray = camera.ray({x + 0.5, y + 0.5});
            constexpr double kNear = 1e-3; // voxels
            if (hitsBox(-kNear, ray)) {
                EXPECT_GT(image.at(x, y).a, 0.0f) << x << ' ' << y;
                ++inside;
            } else if (!hitsBox(kNear, ray)) {
                EXPECT_EQ(image.at(x, y).a, 0.0f) << x << ' ' << y;
            } else {
                ++rim;
            }
        }
    }
    EXPECT_GT(inside, 1000);
    EXPECT_LT(rim, 10);
}

TEST(RayCaster, SeesFromInside)
{
    const auto grid = boxGrid("density", boxOf(40, 40, 40), [](const Coord&) { return 1.0f; });
    const TextureVolume volume(*grid, *grid);
    const Camera camera({.eye = glm::dvec3(19.5), .target = glm::dvec3(30, 19.5, 19.5)}, volume.corners(), {9, 9});
    const Image image = castRays(volume, plainLook(0.05), camera, {.step = 0.1});
    EXPECT_NEAR(std::log(1 - image.at(4, 4).a) / std::log(0.95), 20, 0.1);
}

TEST(RayCaster, PicturesOfAnySizeAreFilled)
{
    const auto grid = boxGrid("density", boxOf(40, 40, 40), [](const Coord&) { return 1.0f; });
    const TextureVolume volume(*grid, *grid);
    for (const glm::ivec2 size : {glm::ivec2(1, 1), glm::ivec2(3, 33), glm::ivec2(17, 16), glm::ivec2(31, 2)}) {
        const Image image = castRays(volume, plainLook(0.5), cameraAlong(volume, {1, 0, 0}, 1e4, 0.01, size), {});
        ASSERT_EQ(image.pixels.size(), std::size_t(size.x) * std::size_t(size.y));
        for (const glm::vec4& pixel : image.pixels)
            EXPECT_GT(pixel.a, 0.99f) << size.x;
    }
}

TEST(RayCaster, RefusesStepsThatMakeNoSense)
{
    for (const double step : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
        EXPECT_THROW((RayCastParams{.step = step}.validate()), ParameterError) << step;
    }
    EXPECT_THROW((RayCastParams{.leastTransmittance = 1}.validate()), ParameterError);
}

} // namespace
} // namespace vdblic
