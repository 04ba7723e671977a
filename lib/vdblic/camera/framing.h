#pragma once

#include "vdblic/camera/camera.h"

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <span>

namespace vdblic {

/// The axes of a view as the columns of a matrix: right, up, forward.
[[nodiscard]] glm::dmat3 viewAxes(const glm::dvec3& forward, const glm::dvec3& up);

/// The direction into which one looks from elevation and azimuth [degrees], as CameraParams::angles has them.
[[nodiscard]] glm::dvec3 viewDirection(const glm::dvec2& angles, const glm::dvec3& up);

/// Position and extent of a camera.
struct Framing {
    glm::dvec3 eye;
    glm::dvec2 halfExtent; ///< as Camera::halfExtent()
};

/// The nearest eye that sees every point; the picture need not be centred on any of them.
///
/// Each edge of a perspective picture bounds the eye's x ∓ extent·z by the outermost point's. Two opposite bounds meet
/// at one depth; the tighter pair of edges decides.
/// @param halfExtent of a perspective at distance 1; of an orthographic picture only its proportions count
[[nodiscard]] Framing frameTightly(Projection projection, const glm::dmat3& axes, std::span<const glm::dvec3> points,
                                   const glm::dvec2& halfExtent);

/// The nearest eye that sees every point with the target in the middle of the picture.
[[nodiscard]] Framing frameAround(const glm::dvec3& target, Projection projection, const glm::dmat3& axes,
                                  std::span<const glm::dvec3> points, const glm::dvec2& halfExtent);

/// The direction of a three-quarter view from the front, the right and above. A flat or long box is seen from a steeper
/// angle or more from the side, so that it fills the picture; a box that lies flat, such as weather, from the front at
/// a height at which it is read as a map; a plate, such as a layer of voxels, nearly along its normal.
[[nodiscard]] glm::dvec3 chooseDirection(Projection projection, const Corners& box, const glm::dvec3& up,
                                         const glm::dvec2& halfExtent);

} // namespace vdblic
