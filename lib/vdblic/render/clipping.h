#pragma once

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <vector>

namespace vdblic {

/// A plane in world space; what lies on the side its normal points to is kept.
struct ClipPlane {
    glm::dvec3 point, normal;
};

/// Cuts by planes, in world space. What is left is convex.
struct ClipParams {
    std::vector<ClipPlane> planes{};
    std::optional<std::array<glm::dvec3, 2>> box{}; ///< low and high corner; what lies inside is kept

    /// @throws ParameterError
    void validate() const;
    /// The planes and the sides of the box.
    [[nodiscard]] std::vector<ClipPlane> allPlanes() const;
    /// The same cuts in a space whose axes are longer by some factors, all above 0.
    [[nodiscard]] ClipParams stretched(const glm::dvec3& factors) const;
};

/// The part of a ray that is left, and the face it comes in through.
struct RayInterval {
    double enter = 0, leave = std::numeric_limits<double>::infinity(); ///< distances from the ray's origin
    std::optional<glm::dvec3> entryNormal{}; ///< outward, of length 1; nothing if the origin itself is inside

    [[nodiscard]] bool empty() const { return !(enter < leave); }

    /// Keep what lies on the side of a plane its normal points to. Origin, direction and normal are in one space, and
    /// `outward` is what the entry normal becomes if the ray comes in here.
    void clip(const glm::dvec3& origin, const glm::dvec3& direction, const ClipPlane& plane, const glm::dvec3& outward);
};

inline void RayInterval::clip(const glm::dvec3& origin, const glm::dvec3& direction, const ClipPlane& plane,
                              const glm::dvec3& outward)
{
    const double above = glm::dot(origin - plane.point, plane.normal);
    const double slope = glm::dot(direction, plane.normal);
    if (slope == 0) {
        if (above < 0) leave = -1;
        return;
    }
    const double crossing = -above / slope;
    if (slope > 0) {
        if (crossing > enter) {
            enter = crossing;
            entryNormal = outward;
        }
    } else {
        leave = std::min(leave, crossing);
    }
}

} // namespace vdblic
