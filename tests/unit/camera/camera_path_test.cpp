#include "vdblic/camera/camera_path.h"

#include "temporary_folder.h"
#include "vdblic/core/errors.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <cmath>

namespace vdblic {
namespace {

Corners box(const glm::dvec3& low, const glm::dvec3& high)
{
    Corners corners;
    for (unsigned i = 0; i < 8; ++i)
        corners[i] = {i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z};
    return corners;
}

const Corners kBox = box({-3, 1, 7}, {15, 9, 20});
const glm::ivec2 kSize(120, 90);

glm::dvec2 project(const Camera& camera, const glm::dvec3& point)
{
    const glm::dvec4 ndc = camera.worldToNdc() * glm::dvec4(point, 1);
    return glm::dvec2(ndc) / ndc.w;
}

void expectNear(const glm::dvec3& a, const glm::dvec3& b, double tolerance = 1e-9)
{
    EXPECT_LT(glm::distance(a, b), tolerance)
        << a.x << ' ' << a.y << ' ' << a.z << ", not " << b.x << ' ' << b.y << ' ' << b.z;
}

TEST(CameraPath, StandsStillByDefault)
{
    const CameraPath path({}, {}, kBox, kSize, {1, 10});
    EXPECT_EQ(path.at(1).worldToNdc(), path.at(7).worldToNdc());
    expectNear(path.at(1).eye(), Camera({}, kBox, kSize).eye());
}

TEST(CameraPath, AnOrbitGoesRoundTheTarget)
{
    CameraParams params{.eye = glm::dvec3(10, 0, 4), .target = glm::dvec3(0, 0, 1)};
    const CameraPath path(params, {.orbit = 1}, kBox, kSize, {101, 8});
    expectNear(path.at(101).eye(), {10, 0, 4});
    expectNear(path.at(103).eye(), {0, 10, 4}); // counter-clockwise seen from above
    expectNear(path.at(105).eye(), {-10, 0, 4});
    expectNear(path.at(109).eye(), {10, 0, 4}); // the first frame again
    expectNear(path.at(103).target(), {0, 0, 1});
    const CameraPath back(params, {.orbit = -0.5, .orbitFrames = 2}, kBox, kSize, {101, 8});
    expectNear(back.at(102).eye(), {0, -10, 4});
}

TEST(CameraPath, AnOrbitSeesTheWholeBoxFromEverywhereAtOneDistance)
{
    for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
        const CameraPath path({.projection = projection}, {.orbit = 1}, kBox, kSize, {1, 37});
        // A part of a turn is seen from no farther away.
        for (const double turns : {0.1, -0.3}) {
            const CameraPath part({.projection = projection}, {.orbit = turns}, kBox, kSize, {1, 37});
            EXPECT_LE(glm::distance(part.at(1).eye(), middleOf(kBox)),
                      1.001 * glm::distance(path.at(1).eye(), middleOf(kBox)));
            for (int frame = 1; frame <= 37; ++frame) {
                for (const glm::dvec3& corner : kBox) {
                    const glm::dvec2 point = project(part.at(frame), corner);
                    EXPECT_LT(std::max(std::abs(point.x - 0.5), std::abs(point.y - 0.5)), 0.5);
                }
            }
        }
        double most = 0;
        for (int frame = 1; frame <= 37; ++frame) {
            const Camera camera = path.at(frame);
            EXPECT_NEAR(glm::distance(camera.eye(), middleOf(kBox)), glm::distance(path.at(1).eye(), middleOf(kBox)),
                        1e-9);
            EXPECT_EQ(camera.halfExtent(), path.at(1).halfExtent());
            for (const glm::dvec3& corner : kBox) {
                const glm::dvec2 point = project(camera, corner);
                most = std::max({most, std::abs(point.x - 0.5), std::abs(point.y - 0.5)});
            }
        }
        EXPECT_LT(most, 0.5);
        EXPECT_GT(most, 0.45);
    }
}

TEST(CameraTrack, PassesThroughItsKeysWithoutKinks)
{
    CameraTrack<double> track;
    const std::pair<int, double> keys[] = {{1, 3}, {11, 7}, {16, 6}, {40, -2}};
    for (const auto& [frame, value] : keys)
        track.add(frame, value);
    constexpr double kStep = 1e-5;
    for (const auto& [frame, value] : keys) {
        EXPECT_NEAR(track.at(frame), value, 1e-12);
        if (frame == 1 || frame == 40) continue;
        const double before = (track.at(frame) - track.at(frame - kStep)) / kStep;
        const double after = (track.at(frame + kStep) - track.at(frame)) / kStep;
        EXPECT_NEAR(before, after, 1e-3);
    }
    EXPECT_EQ(track.at(-100), 3);
    EXPECT_EQ(track.at(100), -2);
}

TEST(CameraTrack, IsExactOnAStraightLineAndAParabola)
{
    CameraTrack<double> line, parabola;
    for (const int frame : {0, 4, 5, 12, 20}) {
        line.add(frame, 2.0 * frame + 1);
        parabola.add(frame, 0.1 * frame * frame);
    }
    for (int half = 0; half <= 40; ++half)
        EXPECT_NEAR(line.at(0.5 * half), half + 1, 1e-12);
    for (int half = 8; half <= 24; ++half)
        EXPECT_NEAR(parabola.at(0.5 * half), 0.025 * half * half, 1e-12);
}

TEST(CameraTrack, RestsBetweenEqualKeys)
{
    CameraTrack<double> track;
    for (const auto& [frame, value] : {std::pair(0, 0.0), {10, 5.0}, {20, 5.0}, {30, -8.0}})
        track.add(frame, value);
    for (int tenth = 100; tenth <= 200; tenth += 7)
        EXPECT_EQ(track.at(0.1 * tenth), 5);
}

class CameraKeyFile : public testing::Test {
  protected:
    CameraMotion motion(const std::string& json) { return {.keys = readCameraKeys(mFolder.add("keys.json", json))}; }
    std::string refusal(const std::string& json)
    {
        try {
            CameraPath({}, motion(json), kBox, kSize, {1, 10});
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("keys.json"), std::string::npos) << error.what();
            return error.what();
        }
        ADD_FAILURE() << "taken: " << json;
        return "";
    }

    TemporaryFolder mFolder;
};

TEST_F(CameraKeyFile, GivesEachPropertyACurveOfItsOwn)
{
    const CameraPath path({.fieldOfView = 20}, motion(R"({"keys": [{"frame": 1, "eye": [50, 0, 5], "target": [0, 0, 5]},
                                              {"frame": 5, "fov": 60},
                                              {"frame": 11, "eye": [60, 20, 5], "up": [0, 1, 1]}]})"),
                          kBox, kSize, {1, 11});
    expectNear(path.at(6).eye(), {55, 10, 5});
    expectNear(path.at(6).target(), {0, 0, 5});
    EXPECT_EQ(path.at(3).fieldOfView(), 60); // constant, from its only key
    expectNear(path.at(2).up(), {0, 1, 1});
}

TEST_F(CameraKeyFile, WhatNoKeyGivesIsChosenOnce)
{
    const CameraPath path({}, motion(R"({"keys": [{"frame": 1, "fov": 20}, {"frame": 9, "fov": 40}]})"), kBox, kSize,
                          {1, 9});
    EXPECT_EQ(path.at(1).eye(), path.at(9).eye());
    EXPECT_NEAR(path.at(5).fieldOfView(), 30, 1e-12);
}

TEST_F(CameraKeyFile, SaysWhatIsWrongWithIt)
{
    EXPECT_NE(refusal("{").find("JSON"), std::string::npos);
    refusal("");
    refusal("[]");
    refusal(R"({"keys": []})");
    refusal(R"({"keys": [7]})");
    refusal(R"({"keys": [{"eye": [1, 2, 3]}]})");
    refusal(R"({"keys": [{"frame": 1.5}]})");
    refusal(R"({"keys": [{"frame": 99999999999999999999}]})");
    refusal(R"({"keys": [{"frame": 18446744073709551615}]})");
    EXPECT_NE(refusal(R"({"keys": [{"frame": -9223372036854775808}]})").find("no usable"), std::string::npos);
    std::string nested =
        R"({"keys": [{"frame": 1, "eye": )" + std::string(200000, '[') + std::string(200000, ']') + "}]}";
    EXPECT_NE(refusal(nested).find("nested too deeply"), std::string::npos);
    EXPECT_NE(refusal(R"({"keys": [{"frame": 3}, {"frame": 2}]})").find("frame 2"), std::string::npos);
    EXPECT_NE(refusal(R"({"keys": [{"frame": 3}, {"frame": 3}]})").find("frame 3"), std::string::npos);
    EXPECT_NE(refusal(R"({"keys": [{"frame": 1, "eye": [1, 2]}]})").find("eye"), std::string::npos);
    refusal(R"({"keys": [{"frame": 1, "fov": "wide"}]})");
    refusal(R"({"keys": [{"frame": 1, "target": [1, 2, null]}]})");
    EXPECT_NE(refusal(R"({"keys": [{"frame": 1, "eyes": [1, 2, 3]}]})").find("eyes"), std::string::npos);
    EXPECT_THROW((void)readCameraKeys(mFolder / "none.json"), InputError);
}

TEST_F(CameraKeyFile, NamesTheFrameInWhichTheCameraSeesNothing)
{
    const CameraPath path({}, motion(R"({"keys": [{"frame": 1, "eye": [9, 9, 9], "target": [0, 0, 0]},
                                              {"frame": 4, "target": [9, 9, 9]}]})"),
                          kBox, kSize, {1, 4});
    EXPECT_NO_THROW((void)path.at(3));
    try {
        (void)path.at(4);
        FAIL();
    } catch (const ParameterError& error) {
        EXPECT_NE(std::string(error.what()).find("frame 4"), std::string::npos) << error.what();
    }
}

TEST(CameraMotion, RefusesWhatHasNoMeaning)
{
    EXPECT_THROW((CameraMotion{.orbit = std::nan("")}.validate()), ParameterError);
    EXPECT_THROW((CameraMotion{.orbit = HUGE_VAL}.validate()), ParameterError);
    EXPECT_THROW((CameraMotion{.orbit = 1, .orbitFrames = 0}.validate()), ParameterError);
    EXPECT_THROW((CameraMotion{.orbitFrames = 10}.validate()), ParameterError);
    CameraKeys keys;
    keys.fieldOfView.add(1, 35);
    EXPECT_THROW((CameraMotion{.orbit = 1, .keys = keys}.validate()), ParameterError);
}

} // namespace
} // namespace vdblic
