#pragma once

#include "vdblic/render/camera.h"

#include <span>

namespace vdblic {

/// The axes of a view as the columns of a matrix: right, up, forward.
[[nodiscard]] glm::dmat3 viewAxes(const glm::dvec3& forward, const glm::dvec3& up);

/// What a picture of given proportions must show, looking along an axis.
struct Framing {
    glm::dvec3 eye;
    glm::dvec2 halfExtent; ///< as Camera's
};

/// The nearest eye that sees every point, wherever the middle of the picture then is.
///
/// Each edge of a perspective picture bounds x ∓ extent·z of the eye by the points' largest; two opposite bounds meet
/// in one place, and the tighter pair of edges decides how far back it is.
/// @param halfExtent of a perspective at distance 1; of an orthographic picture only its proportions count
[[nodiscard]] Framing frameTightly(Projection projection, const glm::dmat3& axes, std::span<const glm::dvec3> points,
                                   const glm::dvec2& halfExtent);

/// The nearest eye that sees every point with the target in the middle of the picture.
[[nodiscard]] Framing frameAround(const glm::dvec3& target, Projection projection, const glm::dmat3& axes,
                                  std::span<const glm::dvec3> points, const glm::dvec2& halfExtent);

/// The direction of a three-quarter view from the front, the right and above: steeper and more from the side as far
/// as a flat or a long box needs it to fill the picture.
[[nodiscard]] glm::dvec3 chooseDirection(Projection projection, const Corners& box, const glm::dvec3& up,
                                         const glm::dvec2& halfExtent);

} // namespace vdblic
