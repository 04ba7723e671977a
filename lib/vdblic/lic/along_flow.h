#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/refinement.h"
#include "vdblic/field/velocity_field.h"

namespace vdblic {

/// Largest `taps` of meanAlongFlow(): positions stay within the next leaf.
inline constexpr int kMostTaps = 4;

/// The mean of a texture along the line of flow through each voxel.
///
/// Samples are the voxel's centre and `taps` positions to each side, a voxel apart along the velocity at the centre,
/// with linearly falling weights: 1 2 3 2 1 for two taps. Where few pathlines pass, neighbouring voxels of one streak
/// differ by chance; the mean removes these grains and keeps edges across the flow. Positions and interpolation corners
/// outside the domain do not count.
///
/// @param velocities of the texture's frame; only directions count
/// @param texture    on the domain; 0 outside
/// @param taps       0 to kMostTaps; 0 gives the texture itself
/// Computed in parallel; the result does not depend on the number of threads.
/// Stalling & Hege, "Fast and resolution independent line integral convolution", SIGGRAPH 1995, filter LIC textures a
/// second time in this way.
[[nodiscard]] LeafValues<float> meanAlongFlow(const Domain& domain, const Refinement& refinement,
                                              const Velocities<Space::kTexture, Per::kStep>& velocities,
                                              const LeafValues<float>& texture, int taps);

} // namespace vdblic
