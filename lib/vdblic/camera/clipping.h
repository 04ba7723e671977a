#pragma once

#include "vdblic/core/parameters.h"

#include <glm/vec3.hpp>

#include <array>
#include <optional>
#include <span>
#include <vector>

namespace vdblic {

/// A plane in world space. The half-space on the side of its normal is kept.
struct ClipPlane {
    glm::dvec3 point, normal;

    /// Distance above the plane, times the length of the normal; negative where it cuts away.
    [[nodiscard]] double height(const glm::dvec3& at) const;
};

/// Whether one of the planes cuts away the whole box.
[[nodiscard]] bool isCutAway(const std::array<glm::dvec3, 8>& corners, std::span<const ClipPlane> planes);

/// Cuts by planes, in world space. The remaining space is convex.
struct ClipParams {
    std::vector<ClipPlane> planes{};
    std::optional<std::array<glm::dvec3, 2>> box{}; ///< low and high corner; its inside is kept

    /// @throws ParameterError
    void validate() const;
    /// The planes and the sides of the box.
    [[nodiscard]] std::vector<ClipPlane> allPlanes() const;
    /// The same cuts in a space that is stretched along its axes. @param factors above 0
    [[nodiscard]] ClipParams stretched(const glm::dvec3& factors) const;
};

[[nodiscard]] Parameters parametersOf(ClipParams& params);

} // namespace vdblic
