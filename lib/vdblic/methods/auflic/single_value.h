#pragma once

#include "vdblic/field/vector.h"
#include "vdblic/lic/hits.h"
#include "vdblic/methods/auflic/particle_bins.h"
#include "vdblic/methods/texture_params.h"

#include <cstddef>
#include <cstdint>

namespace vdblic {

/// The load of a UFLIC pathline: the value of its seed, to the end of the life span (Shen & Kao 1998). Members as in
/// FadingValues.
class SingleValue {
  public:
    static constexpr bool kTakesUp = false, kAlone = false;
    static constexpr std::uint64_t kWeight = 1;

    SingleValue(const TextureParams& params, std::uint64_t step)
        : mStep(step), mLife(std::uint64_t(params.lifeSpan) * std::uint64_t(params.substeps))
    {
    }

    [[nodiscard]] static std::size_t words(const TextureParams& /*params*/) { return 0; }
    [[nodiscard]] static std::uint32_t* now(const Particle& /*particle*/, std::uint32_t* /*words*/) { return nullptr; }
    [[nodiscard]] VDBLIC_INLINE static std::uint64_t atRelease(std::uint64_t value) { return Hits::pack(value, 1); }
    [[nodiscard]] static bool mayTakeUp(const Particle& /*particle*/, const std::uint32_t* /*words*/) { return false; }
    [[nodiscard]] static bool isFull(const std::uint32_t* /*now*/) { return true; }
    static void add(std::uint64_t& /*alive*/, std::uint32_t* /*now*/, std::uint64_t /*value*/) {}
    VDBLIC_INLINE bool age(Particle& particle, std::uint32_t* /*words*/) const
    {
        return mStep - (particle.id >> Particle::kVoxelBits) + 1 < mLife;
    }

  private:
    std::uint64_t mStep, mLife; // steps
};

} // namespace vdblic
