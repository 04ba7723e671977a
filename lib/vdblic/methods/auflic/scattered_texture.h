#pragma once

#include "vdblic/field/velocity_field.h"
#include "vdblic/methods/auflic/convolve.h"
#include "vdblic/methods/auflic/scatter.h"
#include "vdblic/methods/flow_texture.h"

#include <cstdint>
#include <memory>
#include <optional>

namespace vdblic {

/// The textures of UFLIC and AUFLIC (Shen & Kao 1998; Liu & Moorhead 2004).
class ScatteredTexture final : public FlowTexture, public TextureMemory, public LeafState {
  public:
    ScatteredTexture(const TextureParams& params, NoiseField noise);

    [[nodiscard]] TextureFrame advance(const FlowStep& step) override;
    [[nodiscard]] Lengths<Space::kTexture> farthestPath(const Speeds<Space::kTexture, Per::kFrame>& fastest,
                                                        double seconds) const override;
    void handOver(const LeafOwners& owners, std::shared_ptr<const Domain> domain) override;

    /// Up to eight, growing with the state.
    [[nodiscard]] std::size_t parts() const override;
    [[nodiscard]] Saved save(std::size_t part) const override;
    void restore(std::uint64_t steps, double seconds, std::shared_ptr<const Domain> domain,
                 const std::function<std::optional<VdbFile>()>& next) override;

  private:
    /// Scale of slopes, which are displacements in a step and grow with its duration.
    [[nodiscard]] float slopeScale(double seconds) const;

    TextureParams mParams;
    NoiseField mNoise;
    Scatter mScatter;
    std::shared_ptr<const Domain> mDomain; // of the step to come
    std::optional<LeafValues<std::int32_t>> mInput;
    std::optional<RunningMean> mMean; // with substeps
    double mLastSeconds = 0;
    std::uint64_t mStep = 0;
};

} // namespace vdblic
