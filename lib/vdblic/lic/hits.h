#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace vdblic {

/// Sum and number of values in one word, so that one addition scatters both: the sum of 16-bit values in the upper 40
/// bits, the number of hits in the lower 23.
///
/// Words add like the pairs they encode while a voxel has fewer than 2²³ hits a step, which Scatter::step() checks.
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
    /// The number of values in a word that counts each `weight` times: rounded, and 0 only without a hit.
    [[nodiscard]] static constexpr std::int32_t values(std::uint64_t word, std::uint64_t weight)
    {
        return std::int32_t(std::max((count(word) + weight / 2) / weight, std::min<std::uint64_t>(count(word), 1)));
    }
};

/// A texture file's grid of the number of values that each voxel received in its step.
inline constexpr const char* kHitsGrid = "hits";

} // namespace vdblic
