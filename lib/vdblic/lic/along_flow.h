#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/refinement.h"
#include "vdblic/field/velocity_field.h"

namespace vdblic {

/// Largest `taps` of meanAlongFlow(): positions stay within the next leaf.
inline constexpr int kMostTaps = 4;

/// The mean of a texture along the line of flow through each voxel.
///
/// The texture is taken at the voxel's centre and at `taps` positions to each side, a voxel apart along the velocity at
/// the centre, with weights that fall linearly: 1 2 3 2 1 for two taps. Where few pathlines pass, neighbouring voxels
/// of one streak differ by chance; the mean removes these grains and leaves edges across the flow as they are.
/// Positions outside the domain do not count, nor do voxels outside it between which a position lies.
///
/// @param velocities of the texture's frame; only directions count
/// @param texture    on the domain; 0 outside
/// @param taps       0 to kMostTaps; 0 gives the texture itself
/// Computed in parallel; the result does not depend on the number of threads.
/// Stalling & Hege, "Fast and resolution independent line integral convolution", SIGGRAPH 1995, filter LIC textures
/// once more in this way.
[[nodiscard]] LeafValues<float> meanAlongFlow(const Domain& domain, const Refinement& refinement,
                                              const Velocities<Space::kTexture, Per::kStep>& velocities,
                                              const LeafValues<float>& texture, int taps);

} // namespace vdblic
