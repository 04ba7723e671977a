#pragma once

#include "vdblic/field/vector.h"
#include "vdblic/lic/hits.h"
#include "vdblic/methods/auflic/particle_bins.h"
#include "vdblic/methods/auflic/release_turn.h"
#include "vdblic/methods/texture_params.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

/// The load of a pathline of AUFLIC as published: the values of its seeds, each to the end of its life span (Liu &
/// Moorhead 2004). Beside the Hits, one word per frame of the life span: the sum of up to 255 16-bit values in the
/// upper 24 bits, their number in the lower 8. Members as in FadingValues.
///
/// A pathline that collects nothing in a whole step is blocked: it collects no more and ends with its last value.
class ValueWindow {
  public:
    static constexpr bool kTakesUp = true, kAlone = false;
    static constexpr std::uint64_t kWeight = 1;

    ValueWindow(const TextureParams& params, std::uint64_t step) : mTurn(step, params.substeps)
    {
        const auto frames = std::uint64_t(params.lifeSpan), substeps = std::uint64_t(params.substeps);
        for (std::uint64_t release = 0; release < substeps; ++release) {
            const std::uint64_t since = step + (substeps - release) % substeps, frame = since / substeps;
            mPlaces.push_back({std::uint32_t(frame % frames),
                               std::uint32_t((since + frames * substeps - 1) / substeps % frames),
                               std::uint32_t((frame + 1) % frames)});
        }
    }

    [[nodiscard]] static std::size_t words(const TextureParams& params) { return std::size_t(params.lifeSpan); }
    [[nodiscard]] VDBLIC_INLINE std::uint32_t* now(const Particle& particle, std::uint32_t* words) const
    {
        return words + placesOf(particle).now;
    }
    [[nodiscard]] static std::uint64_t atRelease(std::uint64_t /*value*/) { return 0; }
    [[nodiscard]] VDBLIC_INLINE bool mayTakeUp(const Particle& particle, const std::uint32_t* words) const
    {
        return (words[placesOf(particle).before] & kCountMask) != 0;
    }
    [[nodiscard]] VDBLIC_INLINE static bool isFull(const std::uint32_t* now)
    {
        return (*now & kCountMask) == kCountMask;
    }
    VDBLIC_INLINE static void add(std::uint64_t& alive, std::uint32_t* now, std::uint64_t value)
    {
        alive += Hits::pack(value, 1);
        *now += std::uint32_t(value) << kCountBits | 1;
    }
    VDBLIC_INLINE bool age(Particle& particle, std::uint32_t* words) const
    {
        if (mTurn.endsFrameOf(particle.id)) {
            std::uint32_t& oldest = words[placesOf(particle).oldest];
            particle.alive -= Hits::pack(oldest >> kCountBits, oldest & kCountMask);
            oldest = 0;
        }
        return particle.alive != 0;
    }

  private:
    static constexpr int kCountBits = 8;
    static constexpr std::uint32_t kCountMask = (1u << kCountBits) - 1;

    /// Indices of words: of this step, of the previous one, and of the next values to end.
    struct Places {
        std::uint32_t now, before, oldest;
    };
    [[nodiscard]] VDBLIC_INLINE const Places& placesOf(const Particle& particle) const
    {
        return mPlaces[mTurn.substepOf(particle.id)];
    }

    FrameTurn mTurn;
    std::vector<Places> mPlaces; // by the substep of release
};

} // namespace vdblic
