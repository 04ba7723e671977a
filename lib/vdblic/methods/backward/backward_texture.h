#pragma once

#include "vdblic/methods/backward/cell_particles.h"
#include "vdblic/methods/flow_texture.h"
#include "vdblic/methods/texture_params.h"
#include "vdblic/noise/noise_field.h"

#include <cstdint>
#include <memory>
#include <optional>

namespace vdblic {

/// Base of the textures that pull values back along pathlines: IBFV, LEA, UFAC.
///
/// A method carries particles, a texture or both from frame to frame. They are pulled back: each voxel of the next
/// domain looks up its fluid's position a step ago. So a voxel always has a value, and the cost of a step does
/// not depend on earlier ones.
/// A frame's texture is made from its carried values.
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
    /// The values carried between frames; unused parts have no tree.
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
    [[nodiscard]] std::uint64_t steps() const { return mStep; } ///< made so far

  private:
    /// The carried values of the first frame, on its own leaves.
    [[nodiscard]] virtual Carried first(const FlowStep& step) const = 0;
    /// The texture of a step's first frame. @param carried there, halo included
    [[nodiscard]] virtual LeafValues<float> show(const FlowStep& step, const Carried& carried,
                                                 StageClock& clock) const = 0;
    /// The carried values of a step's second frame, on its own leaves. @param before those of its first, halo included
    [[nodiscard]] virtual Carried pullBack(const FlowStep& step, const Carried& before, StageClock& clock) const = 0;

    TextureParams mParams;
    NoiseField mNoise;
    Parts mCarries;
    std::shared_ptr<const Domain> mDomain; // of the next step
    std::optional<Carried> mCarried;       // on its own leaves; nothing before the first step
    std::uint64_t mStep = 0;
};

} // namespace vdblic
