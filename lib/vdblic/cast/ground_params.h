#pragma once

#include "vdblic/core/names.h"
#include "vdblic/core/parameters.h"

#include <glm/vec3.hpp>

#include <array>
#include <optional>
#include <string_view>

namespace vdblic {

/// The side of the domain along which a plane lies: the lowest against up, or the low or high end of a world axis.
enum class GroundSide { kNone, kBelow, kLowX, kHighX, kLowY, kHighY, kLowZ, kHighZ };
template<>
inline constexpr auto kNames<GroundSide> = std::to_array<std::string_view>({"none", "below", "low-x", "high-x", "low-y",
                                                                            "high-y", "low-z", "high-z"});

/// A plane on which volume and solid cast shadows.
struct GroundParams {
    GroundSide side = GroundSide::kNone;
    std::optional<glm::dvec3> color{}; ///< display (sRGB) values; unset: by the background

    /// @throws ParameterError
    void validate() const;
};

[[nodiscard]] Parameters parametersOf(GroundParams& params);

} // namespace vdblic
