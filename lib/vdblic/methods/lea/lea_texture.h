#pragma once

#include "vdblic/methods/backward/backward_params.h"
#include "vdblic/methods/backward/backward_texture.h"

namespace vdblic {

/// Lagrangian-Eulerian advection: noise moves with the fluid (CellParticles) and is blended in place between frames:
///
///     F(x, k) = (1 − α) F(x, k − 1) + α N(x, k)
///
/// A voxel thus holds the noise that passed it; a short filter along the flow follows. Jobard, Erlebacher & Hussaini,
/// "Lagrangian-Eulerian advection of noise and dye textures for unsteady flow visualization", TVCG 8(3), 2002.
///
/// Details that may differ from the authors': the filter is a line integral convolution over a step each way, because
/// blended values lie a step apart along the pathline. Shares are per frame, whatever the substeps. A voxel that is new
/// in the domain begins with its noise.
class LeaTexture final : public BackwardTexture {
  public:
    LeaTexture(const TextureParams& texture, const BackwardParams& params, NoiseField noise);

  private:
    [[nodiscard]] Carried first(const FlowStep& step) const override;
    [[nodiscard]] LeafValues<float> show(const FlowStep& step, const Carried& carried,
                                         StageClock& clock) const override;
    [[nodiscard]] Carried pullBack(const FlowStep& step, const Carried& before, StageClock& clock) const override;

    double mShare; // of the noise, per step
};

} // namespace vdblic
