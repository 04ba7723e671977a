#pragma once

#include "vdblic/methods/flow_texture.h"
#include "vdblic/methods/texture_params.h"
#include "vdblic/noise/noise_field.h"

namespace vdblic {

/// Line integral convolution of each frame on its own, with the noise as its input: the baseline for stills.
///
/// From each voxel's centre the streamline is followed both ways, over half the life span each, so that streaks are as
/// long as those of UFLIC in a steady flow. The weights are a Hann window's. Where the streamline leaves the domain,
/// the kernel ends. Cabral & Leedom, "Imaging vector fields using line integral convolution", SIGGRAPH 1993.
class SteadyTexture final : public FlowTexture {
  public:
    SteadyTexture(const TextureParams& params, NoiseField noise);

    [[nodiscard]] TextureFrame advance(const FlowStep& step) override;
    [[nodiscard]] Lengths<Space::kTexture> farthestPath(const Speeds<Space::kTexture, Per::kFrame>& fastest,
                                                        double seconds) const override;

  private:
    TextureParams mParams;
    NoiseField mNoise;
};

} // namespace vdblic
