#pragma once

#include "vdblic/lic/flow_texture.h"

namespace vdblic {

/// Line integral convolution of each frame on its own, with the noise as its input: the baseline for stills.
///
/// From each voxel's centre the streamline is followed both ways, over half the life span each, so that streaks are as
/// long as those of UFLIC in a steady flow. The weights are a Hann window's. Where the streamline leaves the domain,
/// the kernel ends. Cabral & Leedom, "Imaging vector fields using line integral convolution", SIGGRAPH 1993.
class SteadyTexture final : public FlowTexture {
  public:
    SteadyTexture(const TextureParams& params, NoiseField noise);

    [[nodiscard]] FlowTextureStep advance(const FlowStep& step) override;
    [[nodiscard]] std::uint64_t steps() const override { return mStep; }
    [[nodiscard]] std::array<float, 3> farthestPath(const std::array<float, 3>& displacement,
                                                    double interval) const override;

    // Every frame starts anew: there is no state but the number of steps.
    void handOver(const LeafOwners& /*owners*/, std::shared_ptr<const Domain> /*domain*/) override {}
    [[nodiscard]] std::size_t parts() const override { return 1; }
    [[nodiscard]] Saved save(std::size_t /*part*/) const override { return {}; }
    void restore(std::uint64_t steps, double /*interval*/, std::shared_ptr<const Domain> /*domain*/,
                 const std::function<std::optional<VdbFile>()>& /*next*/) override
    {
        mStep = steps;
    }

  private:
    TextureParams mParams;
    NoiseField mNoise;
    std::uint64_t mStep = 0;
};

} // namespace vdblic
