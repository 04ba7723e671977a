#pragma once

#include "vdblic/methods/flow_texture.h"
#include "vdblic/methods/texture_params.h"
#include "vdblic/noise/noise_field.h"

namespace vdblic {

/// Line integral convolution of each frame on its own, with the noise as its input: the baseline for stills.
///
/// Each voxel's streamline is followed over half the life span both ways: streaks are as long as UFLIC's in a steady
/// flow. The weights are a Hann window's. The kernel ends where the streamline leaves the domain. Cabral & Leedom,
/// "Imaging vector fields using line integral convolution", SIGGRAPH 1993.
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
