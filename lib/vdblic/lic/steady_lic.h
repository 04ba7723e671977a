#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/flow_frame.h"
#include "vdblic/lic/lic_kernel.h"
#include "vdblic/lic/pathline_params.h"
#include "vdblic/noise/noise_field.h"

#include <openvdb/openvdb.h>

namespace vdblic {

/// Line integral convolution of one frame on its own, with the noise as its input: the baseline for stills.
///
/// From each voxel's centre the streamline is followed both ways, over half the life span each, so that streaks are as
/// long as those of UFLIC in a steady flow. Where the streamline leaves the domain, the kernel ends.
///
/// @param frame    velocities and their domain
/// @param toStep   stored value → voxels per step, in index space
/// @param lifeSpan length of the kernel [time steps]
/// @return values in [0, 1]. Computed in parallel; the result does not depend on the number of threads.
/// Cabral & Leedom, "Imaging vector fields using line integral convolution", SIGGRAPH 1993.
[[nodiscard]] LeafValues<float> steadyLic(const FlowFrame& frame, const openvdb::Mat3d& toStep, int lifeSpan,
                                          LicKernel kernel, const PathlineParams& pathline, const NoiseField& noise);

} // namespace vdblic
