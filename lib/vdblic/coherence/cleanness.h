#pragma once

#include "vdblic/coherence/cleanness_figures.h"
#include "vdblic/coherence/coherence_params.h"

#include <cstdint>

namespace vdblic {

class SmoothedTexture;
class VelocityField;

/// Measure how clean a texture is, by class of displacement, without smoothing.
///
/// Points are centres of voxels: params.samples of them, chosen by hash, or all voxels where they are fewer. A point
/// counts where the 7³ voxels around it have values, which excludes the rims of domains and masks; the velocity there
/// at the step's start gives its class.
/// Isolated voxels and the deviation are of the 5³ voxels around the points. Lines come from the structure tensor, the
/// mean over these 5³ voxels of the products of the gradient's components (J. Bigün & G. H. Granlund, Optimal
/// orientation detection of linear symmetry, ICCV 1987). Angles are in the texture's index space. The temporal figures
/// use the points for which the successor has values at the same place and at the end of the pathline.
///
/// @param next  the successor; null if there is none
/// @param field velocity over the step, on the texture's domain and with its refinement
/// Computed in parallel; the result is bit-identical for any number of threads.
[[nodiscard]] CleannessByClass measureCleanness(const SmoothedTexture& texture, const SmoothedTexture* next,
                                                const VelocityField& field, const CoherenceParams& params,
                                                std::int64_t frame);

} // namespace vdblic
