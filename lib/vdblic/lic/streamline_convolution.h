#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/flow/flow_step.h"
#include "vdblic/lic/pathline_params.h"
#include "vdblic/lic/stage_clock.h"

#include <cstddef>
#include <functional>

namespace vdblic {

/// Line integral convolution along the streamlines of one frame: Cabral & Leedom, "Imaging vector fields using line
/// integral convolution", SIGGRAPH 1993.
///
/// From each voxel's centre the streamline is followed both ways. The weights are a Hann window's. Where the streamline
/// leaves the domain, the kernel ends.
struct StreamlineConvolution {
    const FlowStep& step; ///< whose first frame is convolved
    double half;          ///< of the kernel [steps]
    const PathlineParams& pathline;
    /// For kernels of varying length: sets the share of each half to use, 0 to 1, for a leaf's voxels.
    std::function<void(std::size_t leaf, float* parts)> partsOf{};

    /// The texture on the frame's own leaves, with room for all local ones.
    /// @param input on local leaves  @param white its largest value, mapped to 1
    [[nodiscard]] LeafValues<float> operator()(const LeafValues<float>& input, float white, StageClock& clock) const;
};

} // namespace vdblic
