#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <optional>

namespace vdblic {

/// Where the picture is taken from, in world space. What is unset is chosen so that the volume fills the picture.
struct CameraParams {
    std::optional<glm::dvec3> eye{};    ///< unset: a three-quarter view of the target, from far enough to see all
    std::optional<glm::dvec3> target{}; ///< unset: the middle of the volume
    std::optional<glm::dvec3> up{};     ///< unset: +z, or +y when looking along z
    double fieldOfView = 35;            ///< vertical [degrees]

    /// @throws ParameterError
    void validate() const;
};

/// The corners of the box that holds what there is to see, in world space.
using Corners = std::array<glm::dvec3, 8>;

struct Ray {
    glm::dvec3 origin, direction; ///< world space; the direction has length 1
};

/// A camera that has been placed. Immutable.
///
/// Camera space is OpenEXR's: x right, y up, z forward, left-handed. Pixel (0, 0) is the top left one and covers
/// [0, 1) in both directions, so its centre is at (½, ½).
class Camera {
  public:
    /// @param size width and height in pixels
    /// @throws ParameterError if eye and target coincide, or the view is along a given up
    Camera(const CameraParams& params, const Corners& corners, const glm::ivec2& size);

    [[nodiscard]] const glm::ivec2& size() const { return mSize; }
    [[nodiscard]] const glm::dvec3& eye() const { return mEye; }
    [[nodiscard]] const glm::dvec3& target() const { return mTarget; }
    [[nodiscard]] const glm::dvec3& up() const { return mUp; }
    [[nodiscard]] double fieldOfView() const { return mFieldOfView; }

    /// Half the width and height of the picture at distance 1.
    [[nodiscard]] const glm::dvec2& halfExtent() const { return mHalfExtent; }

    [[nodiscard]] const glm::dmat4& worldToCamera() const { return mWorldToCamera; }
    /// World space to the picture, (0, 0) its top left and (1, 1) its bottom right corner, after division by w.
    [[nodiscard]] const glm::dmat4& worldToNdc() const { return mWorldToNdc; }

    /// The ray through a place in the picture, in pixels.
    [[nodiscard]] Ray ray(const glm::dvec2& pixel) const;

  private:
    glm::ivec2 mSize;
    glm::dvec3 mEye, mTarget, mUp;
    double mFieldOfView;
    glm::dmat4 mWorldToCamera, mCameraToWorld, mWorldToNdc;
    glm::dvec2 mHalfExtent;
};

} // namespace vdblic
