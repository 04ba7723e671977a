#pragma once

#include "vdblic/methods/backward/backward_params.h"
#include "vdblic/methods/backward/backward_texture.h"

namespace vdblic {

/// Image based flow visualization: the texture of the step before, pulled back along the pathline and interpolated,
/// blended with a share of noise (PeriodicNoise):
///
///     F(x, k) = (1 − α) F(p, k − 1) + α G(x, k),   p where the fluid of x was a step ago
///
/// so that a voxel holds the noise along its pathline with weights α (1 − α)^i. Van Wijk, "Image based flow
/// visualization", SIGGRAPH 2002, section 3.2; in three dimensions Telea & van Wijk, "3D IBFV: hardware-accelerated 3D
/// flow visualization", Visualization 2003, whose slices a volume in memory does without.
///
/// Beyond the papers:
/// - Theirs ask for steps shorter than the noise's spacing, else a streak is a row of dots. A longer step blends in
///   noise at as many places, evenly along the pathline: as several steps would that do not resample the texture.
///   Shares are those of a frame, whatever its substeps.
/// - Where the fluid came from outside, the papers have black or what the rim has. Here it brings what the noise would
///   have made of it had it come straight on, at its speed: the noise goes on outside the domain.
/// - A voxel that is new in the domain has a way back, along the velocity of its own frame.
class IbfvTexture final : public BackwardTexture {
  public:
    IbfvTexture(const TextureParams& texture, const BackwardParams& params, NoiseField noise);

  private:
    [[nodiscard]] Carried first(const FlowStep& step) const override;
    [[nodiscard]] LeafValues<float> show(const FlowStep& step, const Carried& carried,
                                         StageClock& clock) const override;
    [[nodiscard]] Carried pullBack(const FlowStep& step, const Carried& before, StageClock& clock) const override;

    double mShare; // of the noise, in a step
};

} // namespace vdblic
