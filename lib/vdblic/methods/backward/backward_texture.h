#pragma once

#include "vdblic/methods/backward/cell_particles.h"
#include "vdblic/methods/flow_texture.h"
#include "vdblic/methods/texture_params.h"
#include "vdblic/noise/noise_field.h"

#include <cstdint>
#include <memory>
#include <optional>

namespace vdblic {

/// Base of the textures whose values come back along pathlines: IBFV, LEA, UFAC.
///
/// A method carries particles, a texture or both from frame to frame. Those of the next frame are pulled back: each
/// voxel of its domain looks where its fluid was a step ago. So a voxel always has a value, and the cost of a step does
/// not depend on what was before. The texture of a frame is made from the values carried there.
class BackwardTexture : public FlowTexture, public TextureMemory, public LeafState {
  public:
    [[nodiscard]] TextureFrame advance(const FlowStep& step) final;
    [[nodiscard]] Lengths<Space::kTexture> farthestPath(const Speeds<Space::kTexture, Per::kFrame>& fastest,
                                                        double seconds) const override;
    void handOver(const LeafOwners& owners, std::shared_ptr<const Domain> domain) final;
    [[nodiscard]] std::size_t parts() const final;
    [[nodiscard]] Saved save(std::size_t part) const final;
    void restore(std::uint64_t steps, double seconds, std::shared_ptr<const Domain> domain,
                 const std::function<std::optional<VdbFile>()>& next) final;

  protected:
    /// What a method carries; parts that it does without have no tree.
    struct Carried {
        CellParticles particles;
        LeafValues<float> texture;
    };
    struct Parts {
        bool particles, texture;
    };
    BackwardTexture(const TextureParams& params, NoiseField noise, Parts carries);

    [[nodiscard]] const TextureParams& params() const { return mParams; }
    [[nodiscard]] const NoiseField& noise() const { return mNoise; }
    [[nodiscard]] std::uint64_t steps() const { return mStep; } ///< made before

  private:
    /// What the first frame begins with, on its own leaves.
    [[nodiscard]] virtual Carried first(const FlowStep& step) const = 0;
    /// The texture of the frame that a step starts from. @param carried there, halo included
    [[nodiscard]] virtual LeafValues<float> show(const FlowStep& step, const Carried& carried,
                                                 StageClock& clock) const = 0;
    /// What the frame that a step ends at carries, on its own leaves. @param before at its start, halo included
    [[nodiscard]] virtual Carried pullBack(const FlowStep& step, const Carried& before, StageClock& clock) const = 0;

    TextureParams mParams;
    NoiseField mNoise;
    Parts mCarries;
    std::shared_ptr<const Domain> mDomain; // of the step to come
    std::optional<Carried> mCarried;       // on its own leaves; nothing before the first step
    std::uint64_t mStep = 0;
};

} // namespace vdblic
