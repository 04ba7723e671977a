#pragma once

#include "vdblic/coherence/smoothed_texture.h"
#include "vdblic/core/paging.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/pathline.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace vdblic {

/// Sample the texture of the next frame where the flow carries points to, and where they are.
///
/// @param points have a `position` [texture's index space] and a `velocity` [voxels per step]
/// @param visit  called as visit(point, there, same) for each point that arrives and has both samples: `there` at the
///               end of its pathline, `same` at its own position
template<typename Point, typename Visit>
void forSuccessors(const VelocityField& field, const PathlineParams& pathline, const SmoothedTexture& next,
                   const std::vector<Point>& points, const Visit& visit)
{
    PathBatch batch;
    const Bricks::Window anywhere;
    for (std::size_t first = 0; first < points.size(); first += kLanes) {
        const int count = int(std::min<std::size_t>(kLanes, points.size() - first));
        paging::breathe(std::size_t(count) * paging::kPointBytes);
        batch.lanes = (1u << count) - 1;
        for (int lane = 0; lane < count; ++lane) {
            batch.position.setLane(lane, points[first + std::size_t(lane)].position);
            batch.slope.setLane(lane, points[first + std::size_t(lane)].velocity);
        }
        advancePaths(field, anywhere, pathline, batch);
        for (int lane = 0; lane < count; ++lane) {
            const Point& point = points[first + std::size_t(lane)];
            const SmoothedTexture::Sample there = next.sample(batch.position.lane(lane));
            const SmoothedTexture::Sample same = next.sample(point.position);
            if (batch.arrived >> lane & 1 && there.inside && same.inside) visit(point, there, same);
        }
    }
}

} // namespace vdblic
