#pragma once

#include "vdblic/core/names.h"
#include "vdblic/core/parameters.h"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

/// What streaks are drawn as.
enum class StreakForm { kVoxels, kLines };
template<>
inline constexpr auto kNames<StreakForm> = std::to_array<std::string_view>({"voxels", "lines"});

/// Which streaks there are. What is not given is chosen by the first frame (StreakShape).
struct StreakParams {
    std::optional<std::array<float, 3>> spacing{}; ///< between streaks, along each axis [voxels of the velocity]
    std::optional<float> tail{};                   ///< how far back in time a streak shows its pathline [frames]
    std::string emit{};                            ///< FILE[:GRID] that alone releases streaks; empty: the whole domain
    std::optional<std::array<double, 6>> emitBox{}; ///< the same as a box of world space: lower and upper corner
    StreakForm draw = StreakForm::kVoxels;
    std::vector<std::string> sources{}; ///< NAME=FILE[:GRID]: regions whose number a streak carries once it was there

    /// Whether anything of a streak is given.
    [[nodiscard]] bool areGiven() const;
    /// Whether streaks are released in a part of the domain only. Such streaks are not thinned downstream.
    [[nodiscard]] bool emits() const { return !emit.empty() || emitBox; }

    void validate() const; ///< @throws ParameterError
};
[[nodiscard]] Parameters parametersOf(StreakParams& params);

/// A region whose air is followed, as `sources` names it.
struct StreakSource {
    std::string name, grid; ///< `grid`: FILE[:GRID]
};
/// @throws ParameterError if a text is not NAME=FILE[:GRID], or a name stands twice
[[nodiscard]] std::vector<StreakSource> sourcesOf(const StreakParams& params);

} // namespace vdblic
