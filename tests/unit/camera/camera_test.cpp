#include "vdblic/camera/camera.h"

#include "vdblic/core/errors.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

namespace vdblic {
namespace {

Corners boxOfCorners(const glm::dvec3& low, const glm::dvec3& high)
{
    Corners corners;
    for (unsigned i = 0; i < 8; ++i) {
        corners[i] = {i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z};
    }
    return corners;
}

glm::dvec2 toPixel(const Camera& camera, const glm::dvec3& point)
{
    const glm::dvec4 ndc = camera.worldToNdc() * glm::dvec4(point, 1);
    return glm::dvec2(ndc) / ndc.w;
}

const Corners kFlat = boxOfCorners({-3, 100, 7}, {1500, 900, 20});

TEST(Camera, FramesTheWholeBoxTightly)
{
    for (const glm::ivec2& size : {glm::ivec2(100, 100), glm::ivec2(400, 100), glm::ivec2(50, 300)}) {
        for (const double fieldOfView : {5.0, 35.0, 120.0}) {
            const Camera camera({.fieldOfView = fieldOfView}, kFlat, size);
            double most = 0;
            for (const glm::dvec3& corner : kFlat) {
                const glm::dvec2 point = toPixel(camera, corner);
                most = std::max({most, std::abs(point.x - 0.5), std::abs(point.y - 0.5)});
                EXPECT_GT((camera.worldToCamera() * glm::dvec4(corner, 1)).z, 0);
            }
            EXPECT_LT(most, 0.5);
            EXPECT_GT(most, fieldOfView < 100 ? 0.45 : 0.3); // at wide angles distance counts more
        }
    }
}

TEST(Camera, FillsThePictureWithFlatAndLongBoxes)
{
    // The share of the picture between the extremes of the corners; it may be small in the narrower direction.
    const glm::ivec2 size(160, 90);
    for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
        for (const Corners& flat : {boxOfCorners({0, 0, 0}, {734, 1140, 12}), boxOfCorners({0, 0, 0}, {1140, 734, 12}),
                                    boxOfCorners({0, 0, 0}, {2, 300, 300}), boxOfCorners({0, 0, 0}, {300, 2, 300})}) {
            const Camera camera({.projection = projection}, flat, size);
            glm::dvec2 low(1), high(0);
            for (const glm::dvec3& corner : flat) {
                low = glm::min(low, toPixel(camera, corner));
                high = glm::max(high, toPixel(camera, corner));
            }
            EXPECT_NEAR(low.x + high.x, 1, 1e-9); // centred
            EXPECT_NEAR(low.y + high.y, 1, 1e-9);
            EXPECT_NEAR(std::max(high.x - low.x, high.y - low.y), 1 / 1.08, 1e-9);
            EXPECT_GT(std::min(high.x - low.x, high.y - low.y), 0.35); // 734 : 1140 upright in 16 : 9
        }
    }
}

TEST(Camera, SeesAPlateNearlyAlongItsNormal)
{
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 size(20), normal(0);
        size[axis] = 1;
        normal[axis] = 1;
        const Camera camera({}, boxOfCorners({0, 0, 0}, size), {160, 90});
        const glm::dvec3 forward = glm::normalize(camera.target() - camera.eye());
        EXPECT_NEAR(std::abs(glm::dot(forward, normal)), std::cos(glm::radians(10.0)), 1e-9) << axis;
        EXPECT_GT(camera.up().z, 0.9); // so an orbit turns it
    }
}

TEST(Camera, AnOrthographicPictureHasTheGivenHeightAndNoPerspective)
{
    const Camera camera({.projection = Projection::kOrthographic,
                         .eye = glm::dvec3(0, -10, 0),
                         .target = glm::dvec3(0),
                         .viewHeight = 8},
                        kFlat, {200, 100});
    for (const double depth : {-5.0, 0.0, 500.0}) {
        const glm::dvec2 point = toPixel(camera, {4, depth, 2});
        EXPECT_NEAR(point.x, 0.75, 1e-12);
        EXPECT_NEAR(point.y, 0.25, 1e-12);
    }
    const Ray ray = camera.ray({150, 25});
    EXPECT_LT(glm::distance(ray.origin, glm::dvec3(4, -10, 2)), 1e-12);
    EXPECT_LT(glm::distance(ray.direction, glm::dvec3(0, 1, 0)), 1e-12);
    // Without a height all is seen.
    const Camera fitting({.projection = Projection::kOrthographic, .eye = glm::dvec3(4000, -500, 900)}, kFlat,
                         {80, 60});
    for (const glm::dvec3& corner : kFlat) {
        const glm::dvec2 point = toPixel(fitting, corner);
        EXPECT_TRUE(point.x > 0 && point.x < 1 && point.y > 0 && point.y < 1);
    }
}

TEST(Camera, RaysPassThroughWhatProjectsToTheirPixel)
{
    const Camera camera({.eye = glm::dvec3(1, -2, 3), .target = glm::dvec3(4, 4, 0), .fieldOfView = 50}, kFlat,
                        {300, 200});
    for (const glm::dvec2& pixel : {glm::dvec2(0.5), glm::dvec2(299.5, 0.5), glm::dvec2(17.3, 140.25)}) {
        const Ray ray = camera.ray(pixel);
        EXPECT_NEAR(glm::length(ray.direction), 1, 1e-12);
        const glm::dvec2 point = toPixel(camera, ray.origin + ray.direction * 7.5) * glm::dvec2(300, 200);
        EXPECT_NEAR(point.x, pixel.x, 1e-9);
        EXPECT_NEAR(point.y, pixel.y, 1e-9);
    }
}

TEST(Camera, HasKnownGeometry)
{
    // From y = -10 towards +y with z up: x is to the right, z up; 90 degrees show ±10 at the target.
    const Camera camera({.eye = glm::dvec3(0, -10, 0), .target = glm::dvec3(0), .fieldOfView = 90}, kFlat, {200, 100});
    const auto expectAt = [&](const glm::dvec3& point, double x, double y) {
        EXPECT_NEAR(toPixel(camera, point).x, x, 1e-12);
        EXPECT_NEAR(toPixel(camera, point).y, y, 1e-12);
    };
    expectAt({0, 0, 0}, 0.5, 0.5);
    expectAt({20, 0, 0}, 1, 0.5);
    expectAt({0, 0, 10}, 0.5, 0); // the top
    expectAt({-20, 0, -10}, 0, 1);
    const glm::dvec4 local = camera.worldToCamera() * glm::dvec4(3, 5, 7, 1);
    EXPECT_NEAR(local.x, 3, 1e-12);
    EXPECT_NEAR(local.y, 7, 1e-12);
    EXPECT_NEAR(local.z, 15, 1e-12);
}

TEST(Camera, LooksFromTheFrontAndAboveByDefault)
{
    const Corners cube = boxOfCorners({-1, -1, -1}, {1, 1, 1});
    const Camera zUp({}, cube, {10, 10});
    EXPECT_GT(zUp.eye().x, 0);
    EXPECT_LT(zUp.eye().y, 0);
    EXPECT_GT(zUp.eye().z, 0);
    const Camera yUp({.up = glm::dvec3(0, 1, 0)}, cube, {10, 10});
    EXPECT_GT(yUp.eye().x, 0);
    EXPECT_GT(yUp.eye().y, 0);
    EXPECT_GT(yUp.eye().z, 0);
    // A volume without extent gets a distance too.
    const Camera point({}, boxOfCorners(glm::dvec3(4), glm::dvec3(4)), {10, 10});
    EXPECT_NEAR(glm::length(point.eye() - glm::dvec3(4)), 1, 1e-9);
}

TEST(Camera, LooksFromASideOrByAngles)
{
    const Corners cube = boxOfCorners({-1, -1, -1}, {1, 1, 1});
    const auto forward = [&](const CameraParams& params) {
        const Camera camera(params, cube, {10, 10});
        return glm::normalize(camera.target() - camera.eye());
    };
    const std::pair<ViewSide, glm::dvec3> known[] = {{ViewSide::kTop, {0, 0, -1}},   {ViewSide::kBottom, {0, 0, 1}},
                                                     {ViewSide::kFront, {0, 1, 0}},  {ViewSide::kBack, {0, -1, 0}},
                                                     {ViewSide::kLeft, {1, 0, 0}},   {ViewSide::kRight, {-1, 0, 0}},
                                                     {ViewSide::kNorth, {0, -1, 0}}, {ViewSide::kEast, {-1, 0, 0}},
                                                     {ViewSide::kSouth, {0, 1, 0}},  {ViewSide::kWest, {1, 0, 0}}};
    for (const auto& [side, direction] : known)
        EXPECT_LT(glm::length(forward({.view = side}) - direction), 1e-12) << nameOf(side);
    const double half = std::sqrt(0.5);
    EXPECT_LT(glm::length(forward({.angles = glm::dvec2(45, 90)}) - glm::dvec3(-half, 0, -half)), 1e-12);
    const auto yUp = glm::dvec3(0, 1, 0);
    EXPECT_LT(glm::length(forward({.view = ViewSide::kFront, .up = yUp}) - glm::dvec3(0, 0, -1)), 1e-12);
    EXPECT_LT(glm::length(forward({.view = ViewSide::kTop, .up = yUp}) - glm::dvec3(0, -1, 0)), 1e-12);
    EXPECT_EQ(Camera({.view = ViewSide::kTop}, cube, {10, 10}).up(), glm::dvec3(0, 1, 0)); // a map with north up
    const auto eye = glm::dvec3(5, 0, 0);
    EXPECT_EQ(Camera({.view = ViewSide::kTop, .eye = eye}, cube, {10, 10}).eye(), eye);
}

TEST(Camera, SeesABoxThatLiesFlatAsAMap)
{
    const Corners map = boxOfCorners({0, 0, 0}, {100, 80, 20});
    const Camera camera({}, map, {160, 90});
    const glm::dvec3 forward = glm::normalize(camera.target() - camera.eye());
    EXPECT_NEAR(forward.x, 0, 1e-12); // north, +y, is up
    EXPECT_GT(forward.y, 0.5);
    EXPECT_LT(forward.z, -0.7);
    const Camera across({}, boxOfCorners({0, 0, 0}, {20, 200, 7}), {160, 90});
    EXPECT_GT(std::abs(glm::normalize(across.target() - across.eye()).x), 0.5); // the longer side is across
}

TEST(Camera, LooksStraightDownUnlessUpIsGiven)
{
    const CameraParams down{.eye = glm::dvec3(0, 0, 9), .target = glm::dvec3(0)};
    EXPECT_NEAR(toPixel(Camera(down, kFlat, {10, 10}), {0, 1, 0}).x, 0.5, 1e-12); // y is up
    CameraParams bad = down;
    bad.up = glm::dvec3(0, 0, 2);
    EXPECT_THROW(Camera(bad, kFlat, {10, 10}), ParameterError);
}

TEST(Camera, RefusesWhatHasNoMeaning)
{
    const double nan = std::nan("");
    EXPECT_THROW((CameraParams{.eye = glm::dvec3(nan, 0, 0)}.validate()), ParameterError);
    EXPECT_THROW((CameraParams{.target = glm::dvec3(0, HUGE_VAL, 0)}.validate()), ParameterError);
    EXPECT_THROW((CameraParams{.up = glm::dvec3(0)}.validate()), ParameterError);
    EXPECT_THROW((CameraParams{.eye = glm::dvec3(1), .target = glm::dvec3(1)}.validate()), ParameterError);
    for (const double degrees : {0.0, 1e-300, -1.0, 180.0, nan}) {
        EXPECT_THROW((CameraParams{.fieldOfView = degrees}.validate()), ParameterError) << degrees;
    }
    for (const double height : {0.0, -1.0, nan, HUGE_VAL}) {
        EXPECT_THROW((CameraParams{.projection = Projection::kOrthographic, .viewHeight = height}.validate()),
                     ParameterError)
            << height;
    }
    EXPECT_THROW((CameraParams{.viewHeight = 1}.validate()), ParameterError);
    EXPECT_THROW((void)valueOf<Projection>("isometric"), ParameterError);
    // Too far away for double precision.
    for (const double far : {1e30, 1e308})
        EXPECT_THROW(Camera({.eye = glm::dvec3(far)}, kFlat, {10, 10}), ParameterError);
    EXPECT_THROW(Camera({.eye = glm::dvec3(0)}, boxOfCorners(glm::dvec3(-1), glm::dvec3(1)), {10, 10}), ParameterError);
}

TEST(Camera, APixelCoversMoreFarAway)
{
    const CameraParams params{.eye = glm::dvec3(0), .target = glm::dvec3(0, 10, 0), .fieldOfView = 90};
    const Camera camera(params, kFlat, {80, 40});
    EXPECT_NEAR(camera.pixelSize({3, 10, -5}), 2 * 10 / 40.0, 1e-12);
    EXPECT_NEAR(camera.pixelSize({0, 20, 0}), 1, 1e-12);
    EXPECT_EQ(camera.pixelSize({0, -20, 0}), 0);
    CameraParams parallel = params;
    parallel.projection = Projection::kOrthographic;
    parallel.viewHeight = 20;
    EXPECT_NEAR(Camera(parallel, kFlat, {80, 40}).pixelSize({0, 70, 0}), 0.5, 1e-12);
}

} // namespace
} // namespace vdblic
