#include "vdblic/cast/picture_cuts.h"

#include "cast/test_scene.h"
#include "vdblic/field/leaf_voxel.h"

#include <glm/vec4.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;

constexpr int kCubeSide = 96; // of the volume [voxels]

Corners cubeOf(double low, double high)
{
    Corners box;
    for (unsigned i = 0; i < 8; ++i)
        box[i] = {i & 1 ? high : low, i & 2 ? high : low, i & 4 ? high : low};
    return box;
}

/// From outside, from inside, and in parallel.
std::vector<Camera> camerasOn(const glm::ivec2& size)
{
    const Corners box = cubeOf(-0.5, kCubeSide - 0.5);
    return {Camera({}, box, size), Camera({.eye = glm::dvec3(40, 41, 42), .target = glm::dvec3(60, 20, 50)}, box, size),
            Camera({.projection = Projection::kOrthographic}, box, size)};
}

TEST(PictureCuts, EveryPixelIsOneRanks)
{
    for (const glm::ivec2 size : {glm::ivec2(333, 217), glm::ivec2(20, 9)}) {
        for (int ranks = 1; ranks <= 7; ++ranks) {
            const PictureCuts cuts(camerasOn(size)[0], cubeOf(-0.5, kCubeSide - 0.5), ranks);
            std::vector<int> count(std::size_t(size.x) * std::size_t(size.y));
            for (int rank = 0; rank < ranks; ++rank) {
                const auto& [low, high] = cuts.area(rank);
                EXPECT_TRUE(low.x % 16 == 0 || low.x == size.x) << low.x;
                EXPECT_TRUE(low.y % 16 == 0 || low.y == size.y) << low.y;
                for (int y = low.y; y < high.y; ++y) {
                    for (int x = low.x; x < high.x; ++x)
                        ++count[std::size_t(y) * std::size_t(size.x) + std::size_t(x)];
                }
            }
            EXPECT_TRUE(std::all_of(count.begin(), count.end(), [](int n) { return n == 1; })) << ranks;
        }
    }
}

TEST(PictureCuts, EveryLeafHasOneOwnerAndIsNeededWhereItIsSeen)
{
    for (const Camera& camera : camerasOn({200, 120})) {
        for (const int ranks : {2, 3, 7}) {
            const PictureCuts cuts(camera, cubeOf(-0.5, kCubeSide - 0.5), ranks);
            std::vector<ViewShare> shares;
            for (int rank = 0; rank < ranks; ++rank)
                shares.emplace_back(cuts, rank, glm::dmat4(1));
            const openvdb::CoordBBox around(Coord(-3), Coord(kCubeSide / 8 + 3));
            for (auto leaf = around.begin(); leaf; ++leaf) {
                const Coord origin = *leaf << 3;
                EXPECT_EQ(std::count_if(shares.begin(), shares.end(), [&](auto& share) { return share.owns(origin); }),
                          1);
                for (const ViewShare& share : shares) {
                    EXPECT_LE(share.owns(origin), share.needs(origin, 0));
                    EXPECT_LE(share.needs(origin, 0), share.needs(origin, 8));
                    EXPECT_LE(share.needs(origin, 0), share.needs(origin.offsetBy(8, -8, 8), 8)); // the next leaf
                }
            }
            // Along rays through the pixels' corners, which bound those of all samples.
            for (int rank = 0; rank < ranks; ++rank) {
                const auto& [low, high] = cuts.area(rank);
                for (int y = low.y; y <= high.y && low.x < high.x; y += 4) {
                    for (int x = low.x; x <= high.x; x += 4) {
                        const Ray ray = camera.ray({x, y});
                        for (double distance = 0; distance < 400; distance += 3) {
                            const glm::dvec3 at = glm::floor((ray.origin + ray.direction * distance + 0.5) / 8.0);
                            const Coord origin = Coord(int(at.x), int(at.y), int(at.z)) << 3;
                            ASSERT_TRUE(shares[std::size_t(rank)].needs(origin, 0)) << origin << " " << x << " " << y;
                        }
                    }
                }
            }
        }
    }
}

TEST(PictureCuts, LeavesThatALensSeesAreNeeded)
{
    const Corners box = cubeOf(-0.5, kCubeSide - 0.5);
    for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
        const Camera camera({.projection = projection,
                             .eye = glm::dvec3(-60, -50, 70),
                             .target = glm::dvec3(20, 30, 50),
                             .viewHeight = projection == Projection::kPerspective ? std::optional<double>() : 120,
                             .aperture = 30},
                            box, {200, 120});
        const PictureCuts cuts(camera, box, 5);
        const PictureRays rays = camera.rays();
        const std::optional<Lens> lens = camera.lens();
        ASSERT_TRUE(lens);
        int strays = 0;
        for (int rank = 0; rank < 5; ++rank) {
            const ViewShare share(cuts, rank, glm::dmat4(1));
            const auto& [low, high] = cuts.area(rank);
            for (int y = low.y; y <= high.y && low.x < high.x; y += 8) {
                for (int x = low.x; x <= high.x; x += 8) {
                    for (int point = 0; point < 8; ++point) {
                        const double angle = M_PI / 4 * point;
                        const glm::dvec3 aside = lens->right * std::cos(angle) + lens->up * std::sin(angle);
                        const glm::dvec3 origin = rays.origin({x, y}) + aside;
                        const glm::dvec3 direction = rays.direction({x, y}) - aside * lens->perDepth;
                        for (double depth = 0; depth < 250; depth += 3) {
                            const glm::dvec3 at = glm::floor((origin + direction * depth + 0.5) / 8.0);
                            const Coord leaf = Coord(int(at.x), int(at.y), int(at.z)) << 3;
                            ASSERT_TRUE(share.needs(leaf, 0)) << leaf << " " << x << " " << y;
                            strays += !share.owns(leaf);
                        }
                    }
                }
            }
        }
        EXPECT_GT(strays, 1000);
    }
}

TEST(PictureCuts, RanksHaveAboutEqualParts)
{
    const Corners box = cubeOf(-0.5, 8 * kCubeSide - 0.5);
    const Camera camera({}, box, {800, 600});
    for (const int ranks : {2, 4, 6}) {
        const PictureCuts cuts(camera, box, ranks);
        std::vector<double> needed(std::size_t(ranks), 0);
        const openvdb::CoordBBox leaves(Coord(0), Coord(kCubeSide - 1));
        for (int rank = 0; rank < ranks; ++rank) {
            const ViewShare share(cuts, rank, glm::dmat4(1));
            for (auto leaf = leaves.begin(); leaf; ++leaf)
                needed[std::size_t(rank)] += share.needs(*leaf << 3, 0);
        }
        const double part = double(leaves.volume()) / ranks;
        for (const double count : needed) {
            EXPECT_GT(count, 0.75 * part);
            EXPECT_LT(count, 1.35 * part);
        }
    }
}

TEST(BoxShare, CutsVolumesOfAnyPlace)
{
    for (const openvdb::CoordBBox& box : {openvdb::CoordBBox(Coord(-13, 5, 4090), Coord(99, 40, 4110)),
                                          openvdb::CoordBBox(Coord(0), Coord(0)), openvdb::CoordBBox()}) {
        for (int ranks = 1; ranks <= 7; ++ranks) {
            std::vector<int> owned(std::size_t(ranks), 0);
            for (auto leaf = openvdb::CoordBBox(Coord(-3, 0, 508), Coord(13, 6, 514)).begin(); leaf; ++leaf) {
                int owners = 0;
                for (int rank = 0; rank < ranks; ++rank) {
                    const BoxShare share(box, rank, ranks);
                    const bool owns = share.owns(*leaf << 3);
                    owners += owns;
                    owned[std::size_t(rank)] += owns;
                    EXPECT_EQ(share.needs(*leaf << 3, 0), owns);
                    EXPECT_LE(owns, share.needs((*leaf + Coord(1, -1, 0)) << 3, 8));
                }
                EXPECT_EQ(owners, 1);
            }
            if (box.volume() > 1000) {
                EXPECT_GT(*std::min_element(owned.begin(), owned.end()), 0);
            }
        }
    }
}

} // namespace
} // namespace vdblic
