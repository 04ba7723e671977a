#pragma once

#include "vdblic/methods/backward/backward_params.h"
#include "vdblic/methods/backward/backward_texture.h"

namespace vdblic {

/// Image based flow visualization: the previous texture, pulled back along pathlines by interpolation, is blended with
/// a share of noise (PeriodicNoise):
///
///     F(x, k) = (1 − α) F(p, k − 1) + α G(x, k),   p: position a step ago of the fluid at x
///
/// A voxel thus holds the noise along its pathline with weights α (1 − α)^i. Van Wijk, "Image based flow
/// visualization", SIGGRAPH 2002, section 3.2; in three dimensions Telea & van Wijk, "3D IBFV: hardware-accelerated 3D
/// flow visualization", Visualization 2003, whose slices a volume in memory does without.
///
/// Beyond the papers:
/// - They need steps shorter than the noise's spacing, else a streak is a row of dots. A longer step samples the noise
///   evenly along the pathline, as several steps would, without resampling the texture. Shares are per frame,
///   whatever the substeps.
/// - For fluid from outside, the papers use black or the value at the rim. Here the noise continues outside the domain,
///   and the fluid brings the texture that it would have collected, had it come straight at its speed.
/// - A voxel that is new in the domain is pulled back by the velocity of its own frame.
class IbfvTexture final : public BackwardTexture {
  public:
    IbfvTexture(const TextureParams& texture, const BackwardParams& params, NoiseField noise);

  private:
    [[nodiscard]] Carried first(const FlowStep& step) const override;
    [[nodiscard]] LeafValues<float> show(const FlowStep& step, const Carried& carried,
                                         StageClock& clock) const override;
    [[nodiscard]] Carried pullBack(const FlowStep& step, const Carried& before, StageClock& clock) const override;

    double mShare; // of the noise, per step
};

} // namespace vdblic
