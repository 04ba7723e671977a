#pragma once

#include "vdblic/methods/backward/backward_texture.h"

namespace vdblic {

/// Unsteady flow advection-convolution: noise that moves with the fluid (CellParticles), convolved along the
/// streamlines of its moment. Weiskopf, Erlebacher & Ertl, "A texture-based framework for spacetime-coherent
/// visualization of time-dependent vector fields", Visualization 2003.
///
/// Pathlines carry the noise, lines follow streamlines. The two diverge where the flow is unsteady, which would break
/// a line. So the kernel is shorter where the velocity u changes fast in place: after a time τ streamline and pathline
/// are about ½ |∂u/∂t| τ² apart, and the kernel ends where that is a voxel. The dependence of its length on
/// unsteadiness is the authors'; this rule is ours.
///
/// In a steady flow a texture is SteadyTexture's, of the moved noise.
class UfacTexture final : public BackwardTexture {
  public:
    UfacTexture(const TextureParams& texture, NoiseField noise);

    [[nodiscard]] Lengths<Space::kTexture> farthestPath(const Speeds<Space::kTexture, Per::kFrame>& fastest,
                                                        double seconds) const override;

  private:
    [[nodiscard]] Carried first(const FlowStep& step) const override;
    [[nodiscard]] LeafValues<float> show(const FlowStep& step, const Carried& carried,
                                         StageClock& clock) const override;
    [[nodiscard]] Carried pullBack(const FlowStep& step, const Carried& before, StageClock& clock) const override;
};

} // namespace vdblic
