#pragma once

#include "vdblic/field/vector.h"
#include "vdblic/lic/hits.h"
#include "vdblic/methods/auflic/particle_bins.h"
#include "vdblic/methods/auflic/release_turn.h"
#include "vdblic/methods/texture_params.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace vdblic {

/// The load of an AUFLIC pathline: the values of all its seeds in one Hits word. A value starts with weight kWeight;
/// every frame removes the same share of the remaining weight. A new pathline starts as if it had collected its first
/// seed's value in every earlier frame. So all pathlines in a voxel carry about the same, and one that finds its voxel
/// closed ends: the first one there takes over its values.
///
/// With a share of 4 / (3 L) streaks are as long, and as coherent, as with a window of L frames.
class FadingValues {
  public:
    static constexpr bool kTakesUp = true;       ///< whether pathlines collect the values of open voxels
    static constexpr bool kAlone = true;         ///< whether only the newest pathline continues from a voxel
    static constexpr std::uint64_t kWeight = 32; ///< of one value, so that shares of it are whole numbers

    FadingValues(const TextureParams& params, std::uint64_t step)
        : mLife(std::uint64_t(params.lifeSpan)), mTurn(step, params.substeps)
    {
    }

    /// The number of words of a particle beside its Hits.
    [[nodiscard]] static std::size_t words(const TextureParams& /*params*/) { return 0; }
    /// The word of this step.
    [[nodiscard]] static std::uint32_t* now(const Particle& /*particle*/, std::uint32_t* /*words*/) { return nullptr; }

    /// The Hits of a new pathline, before it collects its seed's value.
    [[nodiscard]] VDBLIC_INLINE std::uint64_t atRelease(std::uint64_t value) const
    {
        const std::uint64_t weight = mLife > 1 ? kWeight * (3 * mLife - 4) / 4 : 0;
        return Hits::pack(value * weight, weight);
    }
    [[nodiscard]] static bool mayTakeUp(const Particle& /*particle*/, const std::uint32_t* /*words*/) { return true; }
    [[nodiscard]] static bool isFull(const std::uint32_t* /*now*/) { return false; }
    /// Collect a value.
    VDBLIC_INLINE static void add(std::uint64_t& alive, std::uint32_t* /*now*/, std::uint64_t value)
    {
        alive += Hits::pack(value * kWeight, kWeight);
    }
    /// Take over the values of an ending pathline.
    static void join(std::uint64_t& alive, std::uint64_t other)
    {
        constexpr std::uint64_t kMostWeight = std::uint64_t(1) << 16;
        if (Hits::count(alive + other) <= kMostWeight) alive += other;
    }
    /// Age a particle's values by this step. @return whether any remain
    VDBLIC_INLINE bool age(Particle& particle, std::uint32_t* /*words*/) const
    {
        if (!mTurn.endsFrameOf(particle.id)) return true;
        particle.alive = faded(particle.alive, mLife);
        return particle.alive != 0;
    }

    /// Hits that remain after a frame.
    [[nodiscard]] static constexpr std::uint64_t faded(std::uint64_t word, std::uint64_t life)
    {
        const std::uint64_t weight = Hits::count(word), sum = Hits::sum(word);
        const auto part = std::uint32_t(8 * weight + 3 * life) / std::uint32_t(6 * life); // sooner than in 64 bits
        const std::uint64_t lost = std::min(std::uint64_t(std::max(part, 1u)), weight);
        return weight > lost ? Hits::pack(sum - sum * lost / weight, weight - lost) : 0;
    }

  private:
    std::uint64_t mLife;
    FrameTurn mTurn;
};

} // namespace vdblic
