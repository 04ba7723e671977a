#include "vdblic/cast/optical_depths.h"

#include "vdblic/cast/extinction_grid.h"

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vdblic {

std::vector<float> opticalDepths(const ExtinctionGrid& grid, const std::vector<float>& extinctions,
                                 const glm::dvec3& towardsLight, double reach, bool countsItself)
{
    const openvdb::Coord& dim = grid.dim();
    int along = 0;
    for (int axis = 1; axis < 3; ++axis) {
        if (std::abs(towardsLight[axis]) > std::abs(towardsLight[along])) along = axis;
    }
    const int second = along == 2 ? 1 : 2, first = 3 - along - second; // rows lie in memory along the second
    const int before = towardsLight[along] > 0 ? 1 : -1;               // the slab that light passes before a cell's
    // The way from a cell's centre to the middle of the slab before: its length [voxels], and where it ends [cells].
    const double length = grid.cell() * glm::length(towardsLight) / std::abs(towardsLight[along]);
    const double ends[] = {towardsLight[first] / std::abs(towardsLight[along]),
                           towardsLight[second] / std::abs(towardsLight[along])};
    const auto half = float(0.5 * length), own = countsItself ? half : 0.0f, kept = float(std::exp(-length / reach));
    struct Corner {
        int i, j;
        float share;
    };
    Corner corners[4]; // of the square of cells around that end
    for (int corner = 0; corner < 4; ++corner) {
        const int steps[] = {corner & 1, corner >> 1};
        double share = 1;
        int low[2];
        for (int side = 0; side < 2; ++side) {
            low[side] = int(std::floor(ends[side]));
            const double fraction = ends[side] - low[side];
            share *= steps[side] ? fraction : 1 - fraction;
        }
        corners[corner] = {low[0] + steps[0], low[1] + steps[1], float(share)};
    }
    const auto cellsOf = [&](int slab, int i) {
        openvdb::Coord cell(0);
        cell[along] = slab;
        cell[first] = i;
        return std::ptrdiff_t(grid.index(cell));
    };
    const std::ptrdiff_t stride = second == 2 ? 1 : dim[2];
    std::vector<float> depths(extinctions.size()), leaving(extinctions.size()); // the latter behind the cells
    for (int n = 0; n < dim[along]; ++n) {
        const int slab = before > 0 ? dim[along] - 1 - n : n;
        tbb::parallel_for(0, dim[first], [&](int i) {
            float* const arriving = depths.data() + cellsOf(slab, i);
            for (const Corner& corner : corners) {
                const int nextI = i + corner.i;
                if (n == 0 || nextI < 0 || nextI >= dim[first]) continue; // outside the volume all light arrives
                const float* const next = leaving.data() + cellsOf(slab + before, nextI) + corner.j * stride;
                const int end = std::min(dim[second], dim[second] - corner.j);
                for (int j = std::max(0, -corner.j); j < end; ++j)
                    arriving[j * stride] += corner.share * next[j * stride];
            }
            const float* const here = extinctions.data() + cellsOf(slab, i);
            float* const behind = leaving.data() + cellsOf(slab, i);
            for (int j = 0; j < dim[second]; ++j) {
                const float left = arriving[j * stride] * kept;
                arriving[j * stride] = left + own * here[j * stride];
                behind[j * stride] = left + 2 * half * here[j * stride];
            }
        });
    }
    return depths;
}

} // namespace vdblic
