#include "vdblic/lic/finish.h"

#include "vdblic/core/errors.h"
#include "vdblic/lic/along_flow.h"
#include "vdblic/lic/sharpen.h"

#include <fmt/format.h>

#include <limits>

namespace vdblic {

void FinishParams::validate() const
{
    if (taps < 0 || taps > kMostTaps) {
        throw ParameterError(fmt::format("`finish` {} must lie between 0 and {} voxels", taps, kMostTaps));
    }
}

LeafValues<float> finish(const FlowFrame& frame, const openvdb::Mat3d& toStep, LeafValues<float> texture,
                         const FinishParams& params)
{
    if (params.taps == 0) return texture;
    const VelocityLevel velocities{frame.velocities->tree(), frame.refinement.toTexture() * toStep};
    const Domain& domain = *frame.domain;
    // The mean replaces the texture, so that there are never three.
    texture = meanAlongFlow(domain, frame.refinement, velocities, texture, params.taps);
    return sharpened(domain, texture, params.sharpen, {0, 1});
}

} // namespace vdblic
