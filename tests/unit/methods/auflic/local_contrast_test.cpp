#include "vdblic/methods/auflic/local_contrast.h"

#include "methods/test_flow.h"
#include "vdblic/noise/noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vdblic {
namespace {

using openvdb::Coord;

/// Moments of the values in the block of 4³ voxels around a voxel: their number, sum and sum of squares.
openvdb::Vec3d blockMoments(const openvdb::FloatTree& values, const Coord& voxel)
{
    const Coord first(voxel[0] & ~3, voxel[1] & ~3, voxel[2] & ~3);
    openvdb::Vec3d moments(0);
    for (auto at = openvdb::CoordBBox::createCube(first, 4).begin(); at; ++at) {
        const double value = values.getValue(*at);
        if (values.isValueOn(*at)) moments += openvdb::Vec3d(1, value, value * value);
    }
    return moments;
}

/// The definition: moments interpolated linearly between the centres of the eight nearest blocks.
openvdb::Vec3d momentsAt(const openvdb::FloatTree& values, const Coord& voxel)
{
    openvdb::Vec3d moments(0);
    for (int corner = 0; corner < 8; ++corner) {
        Coord block;
        double weight = 1;
        for (int axis = 0; axis < 3; ++axis) {
            const double position = (voxel[axis] - 1.5) / 4, below = std::floor(position); // in blocks
            const int side = corner >> axis & 1;
            block[axis] = 4 * (int(below) + side);
            weight *= side == 1 ? position - below : 1 - (position - below);
        }
        moments += weight * blockMoments(values, block);
    }
    return moments;
}

TEST(LocalContrast, IsMeanAndDeviationOfTheBlocksAround)
{
    const auto frames = test::makeFrames({{-3, 2, 1}, {18, 13, 14}}, 1, [](const Coord& at, int) {
        const bool isHole = (at - Coord(5, 6, 7)).asVec3d().length() < 3;
        return isHole ? std::nullopt : std::optional(openvdb::Vec3f(0));
    });
    const Domain& domain = *frames[0].domain.texture;
    LeafValues<float> values(domain, 0.0f);
    for (auto voxel = values.tree()->beginValueOn(); voxel; ++voxel) {
        const Coord at = voxel.getCoord();
        voxel.setValue(float(noiseValue(at[0], at[1], at[2], 1)) / float(kNoiseMax));
    }
    LocalContrast contrast(domain);
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf)
        contrast.add(leaf, values[leaf]);
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf) {
        const LocalContrast::Leaf around(contrast, domain.origin(leaf));
        for (auto voxel = domain.mask(leaf).beginOn(); voxel; ++voxel) {
            const LeafVoxel v = LeafVoxel::at(voxel.pos());
            const LocalContrast::Row row = around.row(v.x, v.y);
            const Coord at = domain.origin(leaf) + Coord(v.x, v.y, v.z);
            const openvdb::Vec3d moments = momentsAt(*values.tree(), at);
            const double mean = moments[1] / moments[0];
            const double deviation = std::sqrt(std::max(moments[2] / moments[0] - mean * mean, 0.0));
            ASSERT_NEAR(row.mean[v.z], mean, 1e-5) << at;
            ASSERT_NEAR(row.deviation[v.z], deviation, 1e-4) << at;
        }
    }
}

} // namespace
} // namespace vdblic
