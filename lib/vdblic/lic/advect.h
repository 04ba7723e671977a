#pragma once

#include "vdblic/core/reporter.h"
#include "vdblic/lic/advect_params.h"

#include <iosfwd>

namespace vdblic {

/// Displacements beyond this many voxels a step are warned of: over such a way the velocity is hardly linear in time.
inline constexpr double kLargeDisplacement = 16;

/// Compute and write the texture of every frame: `density`, `magnitude`, derived grids, what is carried along; reading
/// ahead, computing and writing overlap.
///
/// Checkpoints are written beside the outputs on the way, and when the run ends before its end; the last is removed
/// when it is through (docs/survival.md). With `resume` what follows a checkpoint is the same as without an
/// interruption, and the outputs before it are reported again as finished.
///
/// @param lines source of the paths if the input is `-`
/// @throws ParameterError, InputError, OutputError, Stopped; outputs written before stay
void advectSequence(const AdvectParams& params, std::istream& lines, Reporter& reporter);

} // namespace vdblic
