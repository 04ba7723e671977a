#pragma once

#include "vdblic/core/names.h"
#include "vdblic/core/parameters.h"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

/// The geometry of drawn streaks.
enum class StreakForm { kVoxels, kLines };
template<>
inline constexpr auto kNames<StreakForm> = std::to_array<std::string_view>({"voxels", "lines"});

/// Selection of streaks. The first frame gives defaults (StreakShape).
struct StreakParams {
    std::optional<std::array<float, 3>> spacing{}; ///< between streaks, along each axis [voxels of the velocity]
    std::optional<float> tail{};                   ///< length of the visible pathline back in time [frames]
    std::string emit{}; ///< FILE[:GRID] of the only region that releases streaks; empty: the domain
    std::optional<std::array<double, 6>> emitBox{}; ///< such a region as a world-space box: lower and upper corner
    StreakForm draw = StreakForm::kVoxels;
    std::vector<std::string> sources{}; ///< NAME=FILE[:GRID]: regions; a streak carries the number of its last one

    /// Whether any streak parameter is given.
    [[nodiscard]] bool areGiven() const;
    /// Whether only a part of the domain releases streaks. Such streaks are not thinned downstream.
    [[nodiscard]] bool emits() const { return !emit.empty() || emitBox; }

    void validate() const; ///< @throws ParameterError
};
[[nodiscard]] Parameters parametersOf(StreakParams& params);

/// A region whose air is traced, an entry of `sources`.
struct StreakSource {
    std::string name, grid; ///< `grid`: FILE[:GRID]
};
/// @throws ParameterError if a text is not NAME=FILE[:GRID], or a name occurs twice
[[nodiscard]] std::vector<StreakSource> sourcesOf(const StreakParams& params);

} // namespace vdblic
