#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace vdblic {

/// Sum and number of values in one word, so that one addition scatters both: the sum of 16-bit texture values in the
/// upper 40 bits, the number of hits in the lower 23.
///
/// Words add like the pairs they stand for as long as a voxel collects fewer than 2²³ hits a step; Scatter::step()
/// checks that none collected more.
struct Hits {
    static constexpr int kCountBits = 23;
    static constexpr std::uint64_t kCountMask = (std::uint64_t(1) << kCountBits) - 1;
    /// An accumulator's word where the domain has no voxel: the one negative word.
    static constexpr std::int64_t kOutside = std::numeric_limits<std::int64_t>::min();

    [[nodiscard]] static constexpr std::uint64_t pack(std::uint64_t sum, std::uint64_t count)
    {
        return sum << kCountBits | count;
    }
    [[nodiscard]] static constexpr std::uint64_t sum(std::uint64_t word) { return word >> kCountBits; }
    [[nodiscard]] static constexpr std::uint64_t count(std::uint64_t word) { return word & kCountMask; }
};

/// The values that a particle with history carries, in one word of Hits. A value has weight kWeight when it is taken
/// up; every frame takes away the same share of what is left.
///
/// With a share of 4 / (3 L) streaks are as long, and as coherent, as with a window of L frames (docs/quality.md).
struct FadingHits {
    static constexpr std::uint64_t kWeight = 32;                          ///< so that shares are whole numbers
    static constexpr std::uint64_t kMostWeight = std::uint64_t(1) << 16;  ///< up to which particles are joined
    static constexpr std::uint64_t kWeightLimit = std::uint64_t(1) << 17; ///< of a particle between steps

    /// The word with one more value.
    [[nodiscard]] static constexpr std::uint64_t add(std::uint64_t word, std::uint64_t value)
    {
        return word + Hits::pack(value * kWeight, kWeight);
    }
    /// What is left, after a frame, of one equal value a frame taken up since ever.
    [[nodiscard]] static constexpr std::uint64_t steady(std::uint64_t value, std::uint64_t life)
    {
        const std::uint64_t weight = life > 1 ? kWeight * (3 * life - 4) / 4 : 0;
        return Hits::pack(value * weight, weight);
    }
    /// What is left of the word after a frame.
    [[nodiscard]] static constexpr std::uint64_t fade(std::uint64_t word, std::uint64_t life)
    {
        const std::uint64_t weight = Hits::count(word), sum = Hits::sum(word);
        const auto part = std::uint32_t(8 * weight + 3 * life) / std::uint32_t(6 * life); // sooner than in 64 bits
        const std::uint64_t lost = std::min(std::uint64_t(std::max(part, 1u)), weight);
        return weight > lost ? Hits::pack(sum - sum * lost / weight, weight - lost) : 0;
    }
};

/// Seeds released onto one particle in the steps of one frame, in one word: the sum of up to 255 16-bit values in the
/// upper 24 bits, their number in the lower 8. For AUFLIC without history.
struct Generation {
    static constexpr int kCountBits = 8;
    static constexpr std::uint32_t kMaxCount = (1u << kCountBits) - 1;

    /// @return the word with one more value. @param value 0 to 65535
    [[nodiscard]] static constexpr std::uint32_t add(std::uint32_t word, std::uint32_t value)
    {
        return word + (value << kCountBits | 1);
    }
    [[nodiscard]] static constexpr std::uint32_t count(std::uint32_t word) { return word & kMaxCount; }
    [[nodiscard]] static constexpr std::uint64_t hits(std::uint32_t word)
    {
        return Hits::pack(word >> kCountBits, count(word));
    }
};

} // namespace vdblic
