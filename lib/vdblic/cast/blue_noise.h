#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace vdblic {

/// A square of blue noise that tiles the plane: every rank from 0 to kCount − 1 once, rows from the top. Pixels near
/// each other have ranks far apart, and no direction is preferred, so that it shows as fine grain and never as a hatch.
struct BlueNoise {
    static constexpr int kDim = 32, kCount = kDim * kDim;

    std::array<std::uint16_t, std::size_t(kCount)> ranks;

    /// @param x, y not negative
    [[nodiscard]] int rank(int x, int y) const { return ranks[std::size_t(y % kDim * kDim + x % kDim)]; }
};

/// Made at the first call by the void-and-cluster method (Ulichney 1993), in integers. Thread-safe.
[[nodiscard]] const BlueNoise& blueNoise();

} // namespace vdblic
