#pragma once

#include "vdblic/compare/difference.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

namespace vdblic::compare {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Values are measured in blocks of one leaf.
inline constexpr std::size_t kBlockValues = 512;
/// One bit a value; bit n of word n / 64, as in a leaf's own mask.
using BlockMask = std::array<std::uint64_t, kBlockValues / 64>;

inline bool isOn(const BlockMask& mask, std::size_t n)
{
    return (mask[n / 64] >> (n % 64) & 1) != 0;
}
inline void setOn(BlockMask& mask, std::size_t n)
{
    mask[n / 64] |= std::uint64_t(1) << (n % 64);
}

/// The errors of one block. Values off in `compared` may hold anything.
struct ErrorBlock {
    alignas(64) std::array<double, kBlockValues> error;     ///< finite; 0 where `notFinite` is on
    alignas(64) std::array<double, kBlockValues> magnitude; ///< the larger of |a| and |b|, finite
    alignas(64) std::array<std::array<double, kBlockValues>, 3> components;
    int componentCount = 0;
    BlockMask compared{}, onlyA{}, onlyB{}, notFinite{};
};

/// Errors up to max(absolute, relative · magnitude) are within tolerance.
struct Tolerances {
    double fail = 0, relative = 0;
    double warn = std::numeric_limits<double>::infinity();
};

/// Where a value stands: a voxel's index, or (number of the pair, 0, 0). Places compare in this order.
using Place = std::array<std::int64_t, 3>;

/// What is known of a number of values. Adding two of these in a fixed order gives fixed bits.
struct ValueSums {
    std::uint64_t compared = 0, onlyInA = 0, onlyInB = 0, notFinite = 0, overFail = 0, overWarn = 0, failing = 0;
    double sum = 0, squares = 0, max = 0, maxRelative = 0, peak = 0;
    std::array<double, 3> componentSum{}, componentSquares{}, componentMax{};
    std::optional<Place> first, worst; // worst is that of `max`

    void add(const ValueSums& other);
};

/// Add a block. `placeOf(n)` gives the place of value n and grows with n.
template<typename PlaceOf>
void addBlock(ValueSums& sums, const ErrorBlock& block, const Tolerances& tolerances, const PlaceOf& placeOf);

/// The sums over a block, without places.
[[nodiscard]] ValueSums sumBlock(const ErrorBlock& block, const Tolerances& tolerances);
/// The same for a block known to hold equal values of equal activity; reads `magnitude` and `compared` only.
[[nodiscard]] ValueSums sumEqualBlock(const ErrorBlock& block);
[[nodiscard]] std::size_t firstFailing(const ErrorBlock& block, const Tolerances& tolerances);
/// The first value of the error `max`, which the block has.
[[nodiscard]] std::size_t firstOfError(const ErrorBlock& block, double max);
[[nodiscard]] bool allFinite(const std::array<double, kBlockValues>& values);

/// The figures and the verdict of finished sums; the places are left to the caller.
[[nodiscard]] ValueDifference finish(const ValueSums& sums, int componentCount, double failPercent,
                                     std::optional<double> hardFail);

template<typename PlaceOf>
void addBlock(ValueSums& sums, const ErrorBlock& block, const Tolerances& tolerances, const PlaceOf& placeOf)
{
    ValueSums part = sumBlock(block, tolerances);
    // Looking for a place takes longer than the sums: only where it can matter.
    if (part.failing > 0) part.first = placeOf(firstFailing(block, tolerances));
    if (part.max > 0 && part.max >= sums.max) part.worst = placeOf(firstOfError(block, part.max));
    sums.add(part);
}

} // namespace vdblic::compare
