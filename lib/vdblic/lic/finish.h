#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/lic/flow_frame.h"

#include <openvdb/openvdb.h>

namespace vdblic {

/// How a texture is finished for display. The feedback between steps uses the texture as it was before.
struct FinishParams {
    int taps = 2;         ///< samples to each side along the flow, a voxel apart; 0 leaves the texture as it is
    float sharpen = 0.5f; ///< strength of the high-pass filter after that

    void validate() const; ///< @throws ParameterError
};

/// The texture of a frame, cleaned for display: a mean along the flow, then sharpened.
///
/// A scattering process leaves grains where few pathlines pass. A mean over a few voxels along the line of flow through
/// each voxel, with weights that fall linearly, removes them and leaves edges across the flow as they are; sharpening
/// restores the contrast. Taps outside the domain do not count.
///
/// @param toStep  stored value → any multiple of voxels of the velocity, in index space; only directions count
/// @param texture in [0, 1], on the frame's domain; 0 outside
/// @return in [0, 1], on the frame's domain. Computed in parallel; the result does not depend on the number of threads.
/// Stalling & Hege, "Fast and resolution independent line integral convolution", SIGGRAPH 1995, filter LIC textures
/// once more in this way.
[[nodiscard]] LeafValues<float> finished(const FlowFrame& frame, const openvdb::Mat3d& toStep,
                                         const LeafValues<float>& texture, const FinishParams& params);

} // namespace vdblic
