#pragma once

#include "vdblic/lic/feedback.h"
#include "vdblic/lic/flow_frame.h"
#include "vdblic/lic/pathline.h"

#include <string_view>

namespace vdblic {

/// How the values along a streamline are weighted.
enum class LicKernel {
    kHann, ///< ½ + ½ cos(π s), s from 0 in the middle to 1 at the ends
    kBox,  ///< all alike
};

[[nodiscard]] LicKernel parseLicKernel(std::string_view text); ///< `hann` or `box`. @throws ParameterError
[[nodiscard]] std::string_view toString(LicKernel kernel);

/// Line integral convolution of one frame on its own, with the noise as its input: the baseline for stills.
///
/// From each voxel's centre the streamline is followed both ways, over half the life span each, so that streaks are as
/// long as those that a steady flow gives UFLIC. A half that leaves the domain is weighted over what is left of it.
///
/// @param frame    velocities and their domain
/// @param toStep   stored value → voxels per step, in index space
/// @param lifeSpan length of the kernel [time steps]
/// @return values in [0, 1]. Computed in parallel; the result does not depend on the number of threads.
/// Cabral & Leedom, "Imaging vector fields using line integral convolution", SIGGRAPH 1993.
[[nodiscard]] LeafValues<float> steadyLic(const FlowFrame& frame, const openvdb::Mat3d& toStep, int lifeSpan,
                                          LicKernel kernel, const PathlineParams& pathline, const NoiseField& noise);

} // namespace vdblic
