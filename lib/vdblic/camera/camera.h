#pragma once

#include "vdblic/core/parameters.h"

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <optional>
#include <span>
#include <string_view>

namespace vdblic {

enum class Projection { kPerspective, kOrthographic };
template<>
inline constexpr auto kNames<Projection> = std::to_array<std::string_view>({"perspective", "orthographic"});

/// A side that a picture is seen from; the front is towards −y where +z is up, so that east is right where north is +y.
/// kThreeQuarter is from the front, the right and above, at angles that suit the subject's shape (chooseDirection()).
enum class ViewSide { kThreeQuarter, kTop, kBottom, kFront, kBack, kLeft, kRight, kNorth, kEast, kSouth, kWest };
template<>
inline constexpr auto kNames<ViewSide> = std::to_array<std::string_view>({"three-quarter", "top", "bottom", "front",
                                                                          "back", "left", "right", "north", "east",
                                                                          "south", "west"});

/// The camera of a picture, in world space. Unset members are chosen so that the volume fills the picture.
struct CameraParams {
    Projection projection = Projection::kPerspective;
    ViewSide view = ViewSide::kThreeQuarter; ///< where `eye` and `angles` are unset
    std::optional<glm::dvec2> angles{};      ///< elevation and azimuth [degrees] of an unset eye, seen from the target;
                                             ///< azimuth 0 is the front, 90 the right
    std::optional<glm::dvec3> eye{};         ///< unset: in the direction of the view, from far enough to see all
    std::optional<glm::dvec3> target{}; ///< unset: the middle of the volume, or of its picture if the eye is unset too
    std::optional<glm::dvec3> up{};     ///< unset: +z, or +y when looking along z
    double fieldOfView = 35;            ///< of a perspective, vertical [degrees]
    std::optional<double> viewHeight{}; ///< of an orthographic picture [world]; unset: such that all is seen
    double aperture = 0;                ///< diameter of the lens [world]; 0: a pinhole, all is sharp

    /// @throws ParameterError
    void validate() const;
};
[[nodiscard]] Parameters parametersOf(CameraParams& params);
/// The parameter `view_from`, which sets angles by a place on a globe. @param excludes as of a parameter's info
[[nodiscard]] Parameter viewFromParameter(std::optional<glm::dvec2>& angles, const ViewSide& view,
                                          std::string_view excludes = {});

/// The corners of a box around everything visible, in world space. Bit a of a corner's index is its side along the
/// box's axis a.
using Corners = std::array<glm::dvec3, 8>;

/// The mean of the corners.
[[nodiscard]] glm::dvec3 middleOf(const Corners& box);

struct Ray {
    glm::dvec3 origin, direction; ///< world space; the direction has length 1
};

/// A quantity that is linear in the pixel.
template<typename T>
struct PictureGradient {
    T corner, perX, perY; ///< value at the top left corner of pixel (0, 0), change per pixel

    [[nodiscard]] T operator()(const glm::dvec2& pixel) const { return corner + perX * pixel.x + perY * pixel.y; }
};

/// The rays of a picture, in world space. A direction's component along the view axis is 1.
struct PictureRays {
    PictureGradient<glm::dvec3> origin, direction;
};

/// A thin lens, through which a ray may pass anywhere: at (a, b) of the unit disc its origin moves by a · right + b ·
/// up, and its direction by −perDepth times that. All rays of a point of the picture thus meet in the focal plane.
struct Lens {
    glm::dvec3 right, up; ///< as long as the lens's radius [world]
    double perDepth;      ///< reciprocal depth of the focal plane, through the target
};

/// A rectangle of a picture [pixels].
struct PictureArea {
    glm::ivec2 low, high; ///< the upper bound is excluded
};

/// A camera with position, direction and projection. Immutable.
///
/// Camera space is OpenEXR's: x right, y up, z forward, left-handed. Pixel (0, 0) is the top left one and covers
/// [0, 1) in both directions, so its centre is at (½, ½). Points behind the eye's plane are invisible.
class Camera {
  public:
    /// @param box  around everything visible
    /// @param size width and height [pixels]
    /// @param subject points that the picture is filled with where position or extent are chosen; empty: the corners
    /// @throws ParameterError if eye and target coincide, the view is along a given up, or the eye is too far away
    Camera(const CameraParams& params, const Corners& box, const glm::ivec2& size,
           std::span<const glm::dvec3> subject = {});

    [[nodiscard]] const glm::ivec2& size() const { return mSize; }
    [[nodiscard]] Projection projection() const { return mProjection; }
    [[nodiscard]] const glm::dvec3& eye() const { return mEye; }
    [[nodiscard]] const glm::dvec3& target() const { return mTarget; }
    [[nodiscard]] const glm::dvec3& up() const { return mUp; }
    [[nodiscard]] double fieldOfView() const { return mFieldOfView; }

    /// Half the width and height of the picture at distance 1; of an orthographic one at any distance.
    [[nodiscard]] const glm::dvec2& halfExtent() const { return mHalfExtent; }

    /// The length that a pixel's height covers at a point; 0 behind the eye. @return [world]
    [[nodiscard]] double pixelSize(const glm::dvec3& point) const;

    [[nodiscard]] const glm::dmat4& worldToCamera() const { return mWorldToCamera; }
    /// World space to the picture, (0, 0) its top left and (1, 1) its bottom right corner, after division by w.
    [[nodiscard]] const glm::dmat4& worldToNdc() const { return mWorldToNdc; }

    /// The same camera with every ray shifted in the picture; its matrices stay. @param pixels to the right and down
    [[nodiscard]] Camera shifted(const glm::dvec2& pixels) const;

    /// The same camera for a part of the picture; the other pixels stay empty. @param area of whole
    /// tiles (RaySetup::kTile), but at the picture's right and lower edges
    [[nodiscard]] Camera cropped(const PictureArea& area) const;
    [[nodiscard]] const PictureArea& area() const { return mArea; } ///< the whole picture unless it is cropped

    /// The rays through the middle of the lens.
    [[nodiscard]] PictureRays rays() const;
    /// Nothing if the camera is a pinhole.
    [[nodiscard]] std::optional<Lens> lens() const;
    /// The ray through a point of the picture [pixels].
    [[nodiscard]] Ray ray(const glm::dvec2& pixel) const;

  private:
    glm::ivec2 mSize;
    Projection mProjection;
    glm::dvec3 mEye, mTarget, mUp;
    double mFieldOfView, mLensRadius;
    glm::dmat4 mWorldToCamera, mCameraToWorld, mWorldToNdc;
    glm::dvec2 mHalfExtent;
    glm::dvec2 mShift{0};
    PictureArea mArea;
};

} // namespace vdblic
