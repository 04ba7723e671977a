#include "vdblic/lic/finish.h"

#include "vdblic/core/errors.h"
#include "vdblic/flow/flow_step.h"
#include "vdblic/lic/along_flow.h"
#include "vdblic/lic/sharpen.h"

#include <fmt/format.h>

namespace vdblic {

void FinishParams::validate() const
{
    if (taps < 0 || taps > kMostTaps) {
        throw ParameterError(fmt::format("`finish` {} must lie between 0 and {} voxels", taps, kMostTaps));
    }
}

LeafValues<float> finish(const VelocityFrame& frame, double interval, LeafValues<float> texture,
                         const FinishParams& params)
{
    if (params.taps == 0) return texture;
    // Only directions count, so the step may be the whole interval.
    const auto velocities = frame.domain.refinement.toTexture(FlowStep{frame, frame, interval}.startVelocities());
    const Domain& domain = *frame.domain.texture;
    // The mean replaces the texture: at most two are in memory.
    texture = meanAlongFlow(domain, frame.domain.refinement, velocities, texture, params.taps);
    return sharpened(domain, texture, params.sharpen, {0, 1});
}

} // namespace vdblic
