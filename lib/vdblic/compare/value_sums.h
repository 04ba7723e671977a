#pragma once

#include "vdblic/compare/difference.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

namespace vdblic::compare {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Values are compared in blocks of a leaf's size.
inline constexpr std::size_t kBlockValues = 512;
/// One bit a value, laid out as a leaf's value mask.
using BlockMask = std::array<std::uint64_t, kBlockValues / 64>;

inline bool isOn(const BlockMask& mask, std::size_t n)
{
    return (mask[n / 64] >> (n % 64) & 1) != 0;
}
inline void setOn(BlockMask& mask, std::size_t n)
{
    mask[n / 64] |= std::uint64_t(1) << (n % 64);
}

/// The errors of one block. Entries whose bit in `compared` is off are undefined.
struct ErrorBlock {
    alignas(64) std::array<double, kBlockValues> error;     ///< finite; 0 where `notFinite` is set
    alignas(64) std::array<double, kBlockValues> magnitude; ///< the larger of |a| and |b|, finite
    alignas(64) std::array<std::array<double, kBlockValues>, 3> components;
    int componentCount = 0;
    BlockMask compared{}, onlyA{}, onlyB{}, notFinite{};
};

/// Errors up to max(absolute, relative · magnitude) are within tolerance.
struct Tolerances {
    double fail = 0, relative = 0;
};

/// The position of a value: a voxel's index, or (number of the pair, 0, 0). Ordered lexicographically.
using ValueIndex = std::array<std::int64_t, 3>;

/// Sums over compared values. Adding them in a fixed order gives fixed bits.
struct ValueSums {
    std::uint64_t compared = 0, onlyInA = 0, onlyInB = 0, notFinite = 0, overFail = 0, failing = 0;
    double sum = 0, squares = 0, max = 0, maxRelative = 0, peak = 0;
    std::array<double, 3> componentSum{}, componentSquares{}, componentMax{};
    std::optional<ValueIndex> first, worst; // first failing value; first value of error `max`

    void add(const ValueSums& other);
};

/// Add a block. `indexOf(n)` gives the index of value n of the block and rises with n.
template<typename IndexOf>
void addBlock(ValueSums& sums, const ErrorBlock& block, const Tolerances& tolerances, const IndexOf& indexOf);

/// The sums over a block, without `first` and `worst`.
[[nodiscard]] ValueSums sumBlock(const ErrorBlock& block, const Tolerances& tolerances);
/// sumBlock() for a block whose pairs are known to be equal in value and activity; reads `magnitude` and `compared`.
[[nodiscard]] ValueSums sumEqualBlock(const ErrorBlock& block);
[[nodiscard]] std::size_t firstFailing(const ErrorBlock& block, const Tolerances& tolerances);
/// The first value with the error `max`; the block must have one.
[[nodiscard]] std::size_t firstOfError(const ErrorBlock& block, double max);
[[nodiscard]] bool allFinite(const std::array<double, kBlockValues>& values);

/// The figures and the verdict of finished sums, without `first` and `worst`.
[[nodiscard]] ValueDifference finish(const ValueSums& sums, int componentCount, double failPercent);

template<typename IndexOf>
void addBlock(ValueSums& sums, const ErrorBlock& block, const Tolerances& tolerances, const IndexOf& indexOf)
{
    ValueSums part = sumBlock(block, tolerances);
    // Searching is slower than summing: search only blocks that can change the result.
    if (part.failing > 0) part.first = indexOf(firstFailing(block, tolerances));
    if (part.max > 0 && part.max >= sums.max) part.worst = indexOf(firstOfError(block, part.max));
    sums.add(part);
}

} // namespace vdblic::compare
