#pragma once

#include "vdblic/methods/backward/backward_texture.h"

namespace vdblic {

/// Unsteady flow advection-convolution: noise that moves with the fluid (CellParticles), convolved along the
/// streamlines of its moment. Weiskopf, Erlebacher & Ertl, "A texture-based framework for spacetime-coherent
/// visualization of time-dependent vector fields", Visualization 2003.
///
/// Pathlines carry the noise, and lines are drawn along streamlines. The two part where the flow is unsteady: there a
/// line would not stay one. So the kernel is shorter where the velocity u changes fast at a place: after a time τ
/// streamline and pathline are about ½ |∂u/∂t| τ² apart, and the kernel ends where that is a voxel. That its length
/// follows the unsteadiness is the authors'; this rule is ours.
///
/// In a steady flow a texture is SteadyTexture's, of the noise as it has moved.
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
