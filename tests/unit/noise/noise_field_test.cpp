#include "vdblic/noise/noise_field.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace vdblic {
namespace {

using openvdb::Coord;

/// A voxel alone and the corners of a cube have what fill() gives, generated or of a grid.
TEST(NoiseField, IsTheSameVoxelByVoxelAndByCorners)
{
    const auto grid = openvdb::FloatGrid::create(0.0f);
    for (int i = 0; i < 8; ++i)
        grid->tree().setValue(Coord(-8 + i, 16, i), 0.125f * float(i));
    for (const NoiseField& noise : {NoiseField(7), NoiseField(7, grid)}) {
        const Coord origin(-8, 16, 0);
        std::array<std::int32_t, 512> values;
        noise.fill(origin, values.data());
        for (int offset = 0; offset < 512; ++offset) {
            const Coord local(offset >> 6, offset >> 3 & 7, offset & 7);
            ASSERT_EQ(noise.at(origin + local), values[std::size_t(offset)]) << local;
        }
        for (const int edge : {1, 2, 5}) {
            std::array<std::int32_t, 8> corners;
            noise.atCorners(origin + Coord(1, 0, 2), edge, corners.data());
            for (int corner = 0; corner < 8; ++corner) {
                const Coord step(edge * (corner >> 2), edge * (corner >> 1 & 1), edge * (corner & 1));
                EXPECT_EQ(corners[std::size_t(corner)], noise.at(origin + Coord(1, 0, 2) + step)) << edge << step;
            }
        }
    }
}

} // namespace
} // namespace vdblic
