#include "vdblic/cast/depth_cue.h"

#include "vdblic/camera/camera.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/placed_box.h"

#include <glm/vec4.hpp>

#include <algorithm>
#include <limits>

namespace vdblic {

DepthCue::DepthCue(const PlacedBox& box, const Look& look, const Camera& camera)
{
    double nearest = std::numeric_limits<double>::infinity(), farthest = 0;
    for (const glm::dvec3& corner : box.corners()) {
        const double depth = (camera.worldToCamera() * glm::dvec4(corner, 1)).z;
        nearest = std::min(nearest, std::max(depth, 0.0));
        farthest = std::max(farthest, depth);
    }
    mNearest = float(nearest);
    mPerDepth = farthest > nearest ? float(double(look.depthCue) / (farthest - nearest)) : 0;
}

} // namespace vdblic
