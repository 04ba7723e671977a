#pragma once

#include "vdblic/coherence/coherence_figures.h"
#include "vdblic/coherence/coherence_params.h"

#include <cstdint>

namespace vdblic {

class SmoothedTexture;
class VelocityField;

/// Measure a texture against its successor and the velocity between them.
///
/// Points are chosen by a hash of their number and the frame, uniformly over the texture's voxels and inside them. A
/// point counts where the eight voxels around it have values and the flow moves by params.leastMotion. The temporal
/// figures use the points for which the successor, too, has values at the same position and at the end of the pathline
/// (advancePaths()). The spatial figures follow the streamline of the velocity at the step's start from each point, and
/// a straight line perpendicular to it in a direction that the hash chooses; a point counts for the lags up to which
/// its line stays inside.
/// All correlations are Pearson's, of trilinearly interpolated values.
///
/// A texture may be finer than the velocity. Lags, lengths, the least motion and the right angle are in the
/// velocity's index space, so that textures of different voxels can be compared. The smoothing filter is three
/// texture voxels wide and the integrator's tolerance is in texture voxels, as in vdblic_advect.
///
/// measureCleanness() gives the figures by displacement, with the same parameters.
///
/// @param next  the successor; null if there is none
/// @param field velocity over the step, on the texture's domain and with its refinement
/// Computed in parallel; the result is bit-identical for any number of threads. @throws ParameterError
[[nodiscard]] FrameCoherence measureCoherence(const SmoothedTexture& texture, const SmoothedTexture* next,
                                              const VelocityField& field, const CoherenceParams& params,
                                              std::int64_t frame);

} // namespace vdblic
