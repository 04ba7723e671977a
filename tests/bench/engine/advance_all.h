#pragma once

#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/pathline.h"

namespace vdblic::bench {

/// Advance a particle from the centre of every voxel by one step, eight at a time.
/// @param sink receives a part of each result
void advanceAll(const VelocityField& field, const PathlineParams& params, PathBatch& batch, double& sink);

} // namespace vdblic::bench
