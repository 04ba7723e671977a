#include "vdblic/cast/solid.h"

#include "cast/test_scene.h"
#include "temporary_folder.h"
#include "vdblic/cast/light_grid.h"
#include "vdblic/cast/supersampling.h"
#include "vdblic/core/errors.h"
#include "vdblic/image/image_file.h"
#include "vdblic/io/vdb_file.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

namespace vdblic {
namespace {

using openvdb::Coord;

constexpr double kRadius = 12;
const glm::dvec3 kMiddle(31.5);

/// The depth at which a ray meets the sphere; infinite if it does not.
double sphereDepth(const Ray& ray, const Camera& camera)
{
    const glm::dvec3 from = ray.origin - kMiddle;
    const double along = glm::dot(from, ray.direction), rest = along * along - glm::dot(from, from) + kRadius * kRadius;
    if (rest < 0) return std::numeric_limits<double>::infinity();
    const glm::dvec3 hit = ray.origin + ray.direction * (-along - std::sqrt(rest));
    return (camera.worldToCamera() * glm::dvec4(hit, 1)).z;
}

/// A thin uniform medium of 64³ voxels.
openvdb::FloatGrid::Ptr medium()
{
    return boxGrid("density", boxOf(64, 64, 64), [](const Coord&) { return 1.0f; });
}

class Solids : public testing::Test {
  protected:
    /// Render through the medium with the sphere in its middle, and compare with silhouette, depth and blending.
    void expectSphere(const std::string& source, double tolerance)
    {
        const auto texture = medium();
        const TextureVolume volume(*texture, *texture);
        const Look look = plainLook(0.01);
        const Solid solid = makeSolid(source, *texture, glm::dvec3(1), 1);
        const Camera camera = cameraAlong(volume, {0.8, 0.5, -0.3}, 160, 30, {80, 80});
        const Image image = castSamples(volume, look, camera, {.leastTransmittance = 0, .layers = true}, 1,
                                        {&solid, {0, 1, 0}, nullptr});
        const Image alone = castRays(volume, look, camera, {.leastTransmittance = 0});
        int seen = 0;
        for (int y = 0; y < 80; ++y) {
            for (int x = 0; x < 80; ++x) {
                const double depth = sphereDepth(camera.ray({x + 0.5, y + 0.5}), camera);
                const auto& pixel = image.at(x, y);
                if (!std::isfinite(depth)) {
                    if (std::isfinite(outerDepth(camera, x, y, tolerance))) continue; // may go either way
                    EXPECT_EQ(pixel, alone.at(x, y)) << x << " " << y;
                    continue;
                }
                if (!std::isfinite(outerDepth(camera, x, y, -tolerance))) continue;
                ++seen;
                ASSERT_EQ(pixel.a, 1) << x << " " << y;
                // White medium in front, green sphere behind, nothing from behind the sphere.
                const double entry = entryDepth(volume, camera, x, y);
                const double way =
                    (depth - entry) *
                    glm::length(glm::dvec3(volume.worldToIndex() * glm::dvec4(viewPerDepth(camera, x, y), 0)));
                const double front = 1 - std::pow(0.99, way);
                EXPECT_NEAR(pixel.r, front, 0.012 * (1 + tolerance)) << x << " " << y;
                EXPECT_GT(pixel.g, pixel.r + 0.2f * float(1 - front));
            }
        }
        EXPECT_GT(seen, 150);
    }

    /// The depth of a larger or smaller sphere.
    static double outerDepth(const Camera& camera, int x, int y, double more)
    {
        const Ray ray = camera.ray({x + 0.5, y + 0.5});
        const glm::dvec3 from = ray.origin - kMiddle;
        const double along = glm::dot(from, ray.direction), radius = kRadius + more;
        return along * along - glm::dot(from, from) + radius * radius < 0 ? std::numeric_limits<double>::infinity() : 0;
    }
    static glm::dvec3 viewPerDepth(const Camera& camera, int x, int y)
    {
        const Ray ray = camera.ray({x + 0.5, y + 0.5});
        return ray.direction / (camera.worldToCamera() * glm::dvec4(ray.direction, 0)).z;
    }
    /// Where a ray enters the medium.
    static double entryDepth(const TextureVolume& volume, const Camera& camera, int x, int y)
    {
        const glm::dvec3 along = viewPerDepth(camera, x, y), eye = camera.eye();
        const Corners box = volume.corners();
        double enter = 0;
        for (int axis = 0; axis < 3; ++axis)
            enter = std::max(
                enter, std::min((box[0][axis] - eye[axis]) / along[axis], (box[7][axis] - eye[axis]) / along[axis]));
        return enter;
    }

    TemporaryFolder mFolder;
};

TEST_F(Solids, ALevelSetIsTheSphereItself)
{
    const auto sphere =
        openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(float(kRadius), openvdb::Vec3f(31.5f), 0.5f);
    sphere->setName("body");
    writeVdb(mFolder / "sphere.vdb", {sphere}, {});
    expectSphere((mFolder / "sphere.vdb").string() + ":body", 0.15);
}

TEST_F(Solids, AMaskIsTheSphereToAVoxel)
{
    const auto mask = boxGrid("mask", boxOf(64, 64, 64), [](const Coord& c) {
        return glm::distance(glm::dvec3(c.x(), c.y(), c.z()), kMiddle) < kRadius ? 1.0f : 0.0f;
    });
    writeVdb(mFolder / "mask.vdb", {mask}, {});
    expectSphere((mFolder / "mask.vdb").string(), 0.9);
}

TEST_F(Solids, AMeshIsTheSphereToAVoxel)
{
    constexpr int kRings = 48, kSegments = 96;
    std::ofstream file(mFolder / "sphere.obj");
    const auto vertex = [&](int ring, int segment) {
        const double polar = M_PI * ring / kRings, angle = 2 * M_PI * segment / kSegments;
        file << "v " << kMiddle.x + kRadius * std::sin(polar) * std::cos(angle) << " "
             << kMiddle.y + kRadius * std::sin(polar) * std::sin(angle) << " " << kMiddle.z + kRadius * std::cos(polar)
             << "\n";
    };
    for (int ring = 0; ring < kRings; ++ring) {
        for (int segment = 0; segment < kSegments; ++segment) {
            vertex(ring, segment);
            vertex(ring + 1, segment);
            vertex(ring + 1, segment + 1);
            vertex(ring, segment + 1);
            file << "f -4 -3 -2 -1\n";
        }
    }
    file.close();
    expectSphere((mFolder / "sphere.obj").string(), 0.5);
    std::ofstream(mFolder / "open.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::ofstream(mFolder / "broken.stl") << "solid x\n facet\n";
    for (const char* bad : {"open.obj", "broken.stl", "none.ply", "none.vdb"}) {
        try {
            (void)makeSolid((mFolder / bad).string(), *medium(), glm::dvec3(1), 1);
            ADD_FAILURE() << bad;
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(bad), std::string::npos) << error.what();
        }
    }
}

TEST_F(Solids, AreSeenInShadowAndKeepTheirColourAtAnyExposure)
{
    // A block behind a medium that lets no light through to it, seen through a medium as good as invisible.
    const auto texture = medium();
    for (auto voxel = openvdb::CoordBBox({20, 20, 20}, {43, 43, 43}).begin(); voxel; ++voxel)
        texture->tree().setValueOff(*voxel);
    const TextureVolume volume(*texture, *texture);
    Look look = plainLook(1e-6);
    const Camera camera = cameraAlong(volume, {1, 0, 0}, 1e4, 0.3, {9, 9});
    const Solid solid = makeSolid("domain", *texture, glm::dvec3(1), 1);
    Look opaque = plainLook(0.9);
    opaque.shadows = 1;
    const LightGrid dark = lightIn(volume, opaque, {-1, 0, 0});
    const auto green = [&](const LightGrid* light) {
        return castSamples(volume, look, camera, {}, 1, {&solid, {0, 1, 0}, light}).at(4, 4).g;
    };
    const float lit = green(nullptr), shaded = green(&dark);
    EXPECT_NEAR(lit - shaded, 0.5, 0.02);
    EXPECT_GT(shaded, 0.3);
    look.exposure = 1.5;
    EXPECT_NEAR(exposed({{1, 1}, {glm::vec4(0, green(&dark), 0, 1)}}, 1.5).pixels[0].g, shaded, 1e-4);
}

TEST_F(Solids, HalosInFrontHaveTheirColour)
{
    // A streak before a red sphere on a green ground.
    const auto streak = boxGrid("density", boxOf(21, 21, 21), [](const Coord& c) {
        return float(std::exp(-((c.x() - 10) * (c.x() - 10) + (c.y() - 10) * (c.y() - 10)) / 18.0));
    });
    const TextureVolume volume(*streak, *streak);
    Look look{TransferFunction({.colorMap = "gray", .opacity = {{0, 0.9}}, .range = std::array{-2.0, -1.0}}),
              {0, 1, 1, 0},
              {.model = ShadingModel::kNone}};
    look.background.color = {0, 1, 0};
    const Solid sphere{openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(30, openvdb::Vec3f(60, 10, 10), 1)};
    const Camera camera = cameraAlong(volume, {1, 0, 0}, 1e4, 0.12, {51, 51});
    const auto seen = [&](const Solid* solid) {
        return castSamples(volume, look, camera, {}, 1, {solid, {1, 0, 0}, nullptr});
    };
    const Image plain = seen(&sphere);
    look.halo.strength = 2;
    const Image with = seen(&sphere), open = seen(nullptr);
    float most = 0;
    for (int x = 0; x < 51; ++x) {
        EXPECT_LE(with.at(x, 25).g, plain.at(x, 25).g + 1e-3f) << x;
        most = std::max(most, open.at(x, 25).g - with.at(x, 25).g);
    }
    EXPECT_GT(most, 0.3f); // without the sphere halos are green
}

TEST_F(Solids, TheDomainLeavesOutABox)
{
    // A camera along x, stretched along z: the hole is 20 voxels high and wide.
    const auto texture = boxGrid("density", boxOf(64, 64, 64), [](const Coord&) { return 1.0f; });
    for (auto voxel = openvdb::CoordBBox({22, 22, 22}, {41, 41, 41}).begin(); voxel; ++voxel)
        texture->tree().setValueOff(*voxel);
    const glm::dvec3 stretch(1, 1, 2);
    const TextureVolume volume(*texture, *texture, stretch);
    const Solid solid = makeSolid("domain", *texture, stretch, 1);
    const Camera camera({.projection = Projection::kOrthographic,
                         .eye = glm::dvec3(-100, 31.5, 63),
                         .target = glm::dvec3(0, 31.5, 63),
                         .viewHeight = 128},
                        volume.corners(), {128, 128});
    // A ray meets the medium at 99.5 and the solid 22 voxels later; its depth is the mean over what is seen.
    for (const double opacity : {0.5, 0.001}) {
        const Look look = plainLook(opacity);
        const Image image = castSamples(volume, look, camera, {.leastTransmittance = 0, .layers = true}, 1,
                                        {&solid, {0, 1, 0}, nullptr});
        const double behind = std::pow(1 - opacity, 22);
        const double before =
            99.5 - (1 - behind) / std::log1p(-opacity) - image.layers[std::size_t(64 * 128 + 64)].depth;
        EXPECT_NEAR(before, 0, 0.05 + 0.05 * behind);
        // White in front, green behind: half lit from the eye, half from everywhere, more from above at the left.
        const glm::dvec3 key = glm::normalize(keyLight(look, camera));
        const double lit = 0.5 + 0.5 * (1 + 0.5 * (glm::dot(key, glm::dvec3(-1, 0, 0)) - 1) / 2);
        EXPECT_NEAR(image.at(64, 64).g - image.at(64, 64).r, behind * lit, 0.01);
        const auto isGreen = [&](int x, int y) { return image.at(x, y).g - image.at(x, y).r > 0.25 * behind; };
        int wide = 0, high = 0;
        for (int i = 0; i < 128; ++i) {
            wide += isGreen(i, 64);
            high += isGreen(64, i);
        }
        EXPECT_EQ(wide, 20);
        EXPECT_NEAR(high, 41, 1); // half a voxel is a pixel
    }
}

/// Where the surface of a solid lies between two neighbours along x.
double surfaceBetween(const Solid& solid, const Coord& a, const Coord& b)
{
    const double inA = solid.levelSet->tree().getValue(a), inB = solid.levelSet->tree().getValue(b);
    EXPECT_LT(inA * inB, 0) << a << " " << b;
    return a.x() + (b.x() - a.x()) * inA / (inA - inB);
}

TEST_F(Solids, HaveAnExtent)
{
    const auto texture = medium();
    const glm::dvec3 stretch(1, 1, 3);
    EXPECT_TRUE(solidExtent(makeSolid("domain", *texture, stretch, 1)).empty()); // the flow fills its box
    const openvdb::CoordBBox box({10, 20, 30}, {19, 33, 51});
    for (auto at = box.begin(); at; ++at)
        texture->tree().setValueOff(*at);
    glm::dvec3 low(1e9), high(-1e9);
    for (const glm::dvec3& point : solidExtent(makeSolid("domain", *texture, stretch, 1))) {
        low = glm::min(low, point);
        high = glm::max(high, point);
    }
    // Whole voxels around the surface.
    EXPECT_LT(glm::distance(low, stretch * glm::dvec3(9.5, 19.5, 29.5)), 3.5);
    EXPECT_LT(glm::distance(high, stretch * glm::dvec3(19.5, 33.5, 51.5)), 3.5);
}

TEST_F(Solids, EndHalfAVoxelFromTheLastCentres)
{
    constexpr double kTolerance = 0.1;
    const openvdb::CoordBBox box({22, 22, 22}, {41, 41, 41}), wall({10, 5, 5}, {10, 50, 50}),
        thicker({54, 5, 5}, {56, 50, 50}), line({50, 9, 5}, {50, 9, 50});
    const auto texture = medium();
    const auto mask = openvdb::FloatGrid::create();
    for (const openvdb::CoordBBox& part : {box, wall, thicker, line}) {
        for (auto at = part.begin(); at; ++at) {
            texture->tree().setValueOff(*at);
            mask->tree().setValueOn(*at, 1);
        }
    }
    writeVdb(mFolder / "mask.vdb", {mask}, {});
    for (const std::string& source : {std::string("domain"), (mFolder / "mask.vdb").string()}) {
        const Solid solid = makeSolid(source, *texture, glm::dvec3(1), 1);
        const auto expectFaces = [&](int low, int high, int y, int z) {
            EXPECT_NEAR(surfaceBetween(solid, {low - 1, y, z}, {low, y, z}), low - 0.5, kTolerance);
            EXPECT_NEAR(surfaceBetween(solid, {high + 1, y, z}, {high, y, z}), high + 0.5, kTolerance);
        };
        expectFaces(22, 41, 31, 31);
        expectFaces(22, 41, 27, 36); // towards an edge
        expectFaces(22, 41, 22, 22); // at a corner
        expectFaces(10, 10, 30, 30);
        expectFaces(54, 56, 30, 30);
        EXPECT_LT(solid.levelSet->tree().getValue({50, 9, 30}), -0.2); // a line stays
    }
}

} // namespace
} // namespace vdblic
