#include "vdblic/coherence/texture_cube.h"

#include <openvdb/math/Mat3.h>

#include <algorithm>
#include <array>

namespace vdblic {

int TextureCube::countIsolated(float distance) const
{
    int count = 0;
    forEachInner([&](int x, int y, int z) {
        // Few voxels are beyond even their neighbours along z.
        const float value = at(x, y, z);
        float low = std::min(at(x, y, z - 1), at(x, y, z + 1)), high = std::max(at(x, y, z - 1), at(x, y, z + 1));
        if (value <= high + distance && value >= low - distance) return;
        for (int i = x - 1; i <= x + 1; ++i) {
            for (int j = y - 1; j <= y + 1; ++j) {
                if (i == x && j == y) continue;
                for (int k = z - 1; k <= z + 1; ++k) {
                    low = std::min(low, at(i, j, k));
                    high = std::max(high, at(i, j, k));
                }
            }
        }
        count += value > high + distance || value < low - distance;
    });
    return count;
}

TextureCube::Lines TextureCube::lines() const
{
    std::array<float, 6> sums{};
    forEachInner([&](int x, int y, int z) {
        const float dx = at(x + 1, y, z) - at(x - 1, y, z), dy = at(x, y + 1, z) - at(x, y - 1, z),
                    dz = at(x, y, z + 1) - at(x, y, z - 1);
        sums[0] += dx * dx;
        sums[1] += dx * dy;
        sums[2] += dx * dz;
        sums[3] += dy * dy;
        sums[4] += dy * dz;
        sums[5] += dz * dz;
    });
    const auto [xx, xy, xz, yy, yz, zz] = sums;
    const openvdb::math::Mat3d tensor(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    openvdb::math::Mat3d directions;
    openvdb::math::Vec3d widths;
    openvdb::math::diagonalizeSymmetricMatrix(tensor, directions, widths);
    std::array<int, 3> order = {0, 1, 2};
    std::sort(order.begin(), order.end(), [&](int a, int b) { return widths[a] < widths[b]; });
    const double w1 = std::max(widths[order[0]], 0.0), w2 = widths[order[1]], w3 = widths[order[2]];
    constexpr double kRounding = 1e-6; // of w3; the texture does not change along a direction of less
    if (!(w2 > kRounding * w3)) return {};
    return {(w2 - w1) / (w2 + w1), directions.col(order[0])};
}

} // namespace vdblic
