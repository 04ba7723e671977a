#include "cast/test_scene.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Mat4d;
using openvdb::Vec3d;

/// Transforms with every part that is allowed: scale per axis, rotation, translation, mirrored axes.
std::vector<Mat4d> transforms()
{
    auto turned = openvdb::math::scale<Mat4d>(Vec3d(0.3, 1.1, 0.7));
    turned.postRotate(openvdb::math::X_AXIS, 0.4);
    turned.postRotate(openvdb::math::Z_AXIS, 2.2);
    turned.postTranslate(Vec3d(-40, 7, 3));
    Mat4d mirrored = openvdb::math::scale<Mat4d>(Vec3d(1, -1, 1)) * turned;
    return {Mat4d::identity(), openvdb::math::scale<Mat4d>(Vec3d(0.1)), turned, mirrored};
}

glm::dvec2 project(const Camera& camera, const Vec3d& point)
{
    const glm::dvec4 ndc = camera.worldToNdc() * glm::dvec4(point[0], point[1], point[2], 1);
    return glm::dvec2(ndc) / ndc.w * glm::dvec2(camera.size());
}

TEST(Projection, AVoxelsCentreProjectsWhereTheTransformSays)
{
    for (const Mat4d& matrix : transforms()) {
        for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
            for (const Coord& voxel : {Coord(0), Coord(7, -9, 13), Coord(-8, 4, 15)}) {
                const auto grid = boxGrid("density", {voxel, voxel}, [](const Coord&) { return 0.5f; });
                grid->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
                const TextureVolume volume(*grid, *grid);
                // Look past the voxel, so that it is not in the middle of the picture.
                const Vec3d centre = grid->indexToWorld(voxel);
                const glm::dvec3 target(centre[0] + 0.4, centre[1] - 0.3, centre[2] + 0.5);
                CameraParams params{.projection = projection,
                                    .eye = target + glm::dvec3(60, -80, 50),
                                    .target = target,
                                    .fieldOfView = 2};
                if (projection == Projection::kOrthographic) params.viewHeight = 4;
                const Camera camera(params, volume.corners(), {200, 160});
                const Image image = castRays(volume, plainLook(0.02), camera, {.step = 0.05});

                // Its centre of mass in the picture.
                glm::dvec2 sum(0);
                double total = 0;
                for (int y = 0; y < 160; ++y) {
                    for (int x = 0; x < 200; ++x) {
                        const double depth = -std::log(1.0 - image.at(x, y).a);
                        sum += depth * glm::dvec2(x + 0.5, y + 0.5);
                        total += depth;
                    }
                }
                ASSERT_GT(total, 0);
                const glm::dvec2 expected = project(camera, centre), found = sum / total;
                EXPECT_NEAR(found.x, expected.x, 0.1);
                EXPECT_NEAR(found.y, expected.y, 0.1);
            }
        }
    }
}

TEST(Projection, AnOrthographicPictureOfAPatternIsThePattern)
{
    // A plate of voxels, some of them active; four pixels per voxel.
    constexpr int kWidth = 12, kHeight = 9, kPixels = 4;
    const auto there = [](int x, int z) { return (x * 5 + z * 3 + x * z) % 7 < 3; };
    auto grid = openvdb::FloatGrid::create();
    for (int x = 0; x < kWidth; ++x) {
        for (int z = 0; z < kHeight; ++z) {
            if (there(x, z)) grid->tree().setValueOn(Coord(x, 5, z), 0.5f);
        }
    }
    grid->setTransform(
        openvdb::math::Transform::createLinearTransform(openvdb::math::scale<Mat4d>(Vec3d(0.5, 3, 0.5))));
    const TextureVolume volume(*grid, *grid);
    // Seen along +y: x is to the right, z up; voxel (0, 5, 0) covers the bottom left four by four pixels.
    const glm::dvec3 middle((kWidth - 1) / 2.0 * 0.5, 15, (kHeight - 1) / 2.0 * 0.5);
    const CameraParams params{.projection = Projection::kOrthographic,
                              .eye = middle - glm::dvec3(0, 30, 0),
                              .target = middle,
                              .viewHeight = kHeight * 0.5};
    const Camera camera(params, volume.corners(), {kWidth * kPixels, kHeight * kPixels});
    const Image image = castRays(volume, plainLook(0.9), camera, {.step = 0.01});
    for (int y = 0; y < kHeight * kPixels; ++y) {
        for (int x = 0; x < kWidth * kPixels; ++x) {
            const bool expected = there(x / kPixels, kHeight - 1 - y / kPixels);
            EXPECT_NEAR(image.at(x, y).a, expected ? 0.9 : 0.0, 0.01) << x << ' ' << y;
        }
    }
}

} // namespace
} // namespace vdblic
