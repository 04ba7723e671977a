#include "vdblic/camera/camera.h"

#include "vdblic/camera/framing.h"
#include "vdblic/core/errors.h"
#include "vdblic/image/vector_text.h"

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

namespace vdblic {
namespace {

constexpr double kLeastFieldOfView = 0.001; // degrees
constexpr double kFarthest = 1e7;           // distance of the eye, in diagonals of the box

// Squares of larger lengths overflow single precision.
constexpr double kFarthestCoordinate = 1e18;

bool representable(const glm::dvec3& v)
{
    return std::abs(v.x) <= kFarthestCoordinate && std::abs(v.y) <= kFarthestCoordinate &&
           std::abs(v.z) <= kFarthestCoordinate;
}

/// Elevation and azimuth of a side [degrees].
glm::dvec2 anglesOf(ViewSide side)
{
    switch (side) {
    case ViewSide::kTop:
        return {90, 0};
    case ViewSide::kBottom:
        return {-90, 0};
    case ViewSide::kBack:
    case ViewSide::kNorth:
        return {0, 180};
    case ViewSide::kLeft:
    case ViewSide::kWest:
        return {0, -90};
    case ViewSide::kRight:
    case ViewSide::kEast:
        return {0, 90};
    default:
        return {0, 0};
    }
}

bool parallel(const glm::dvec3& a, const glm::dvec3& b)
{
    return glm::length(glm::cross(glm::normalize(a), glm::normalize(b))) < 1e-9;
}

/// Refuse a point so far away that double precision cannot tell voxels apart or that lengths overflow.
void checkDistance(const char* name, const glm::dvec3& point, const Corners& box)
{
    const double diagonal = glm::length(box[7] - box[0]);
    if (glm::length(point - middleOf(box)) <= kFarthest * std::max(diagonal, 1e-6)) return;
    throw ParameterError(fmt::format("camera {} {} is too far from the volume around {}; bring it closer", name,
                                     vectorText(point), vectorText(middleOf(box))));
}

} // namespace

glm::dvec3 middleOf(const Corners& box)
{
    glm::dvec3 middle(0);
    for (const glm::dvec3& corner : box)
        middle += corner / 8.0;
    return middle;
}

Parameter viewFromParameter(std::optional<glm::dvec2>& angles, const ViewSide& view, std::string_view excludes)
{
    constexpr double kFrontToEast = 90; // the front is towards −y, longitude 0 along x
    const auto set = [&angles, &view](const Words& words) {
        if (angles || view != ViewSide::kThreeQuarter)
            throw ParameterError(fmt::format("`view_from` and `{}` exclude each other", angles ? "angles" : "view"));
        angles = glm::dvec2(detail::numberIn(words[1]).value(), detail::numberIn(words[0]).value() + kFrontToEast);
    };
    return parameter("view_from", "The place of a globe that the view is from above.", WordType::kNumber, 2, set,
                     [] { return Words{}; },
                     {.unit = "degrees", .words = "LONGITUDE LATITUDE", .limits = {-360, 360}, .excludes = excludes});
}

Parameters parametersOf(CameraParams& params)
{
    return {
        parameter(
            "view",
            "Side that the volume is seen from, with all of every frame in sight. Where north is +y, south is the "
            "front and east the right.",
            params.view, {.words = "SIDE", .excludes = "eye"}),
        parameter("angles", "The same by angles: height above the horizon, and turn from the front to the right.",
                  params.angles,
                  {.unit = "degrees", .words = "ELEVATION AZIMUTH", .limits = {-360, 360}, .excludes = "view"}),
        viewFromParameter(params.angles, params.view, "eye"),
        parameter("eye", "Position of the camera; by default as `view` says.", params.eye,
                  {.unit = "world", .words = "X Y Z", .excludes = "angles"}),
        parameter("target", "Position the camera looks at; the middle by default.", params.target,
                  {.unit = "world", .words = "X Y Z"}),
        parameter("up", "Direction that is up in the image; 0 0 1 by default.", params.up, {.words = "X Y Z"}),
        parameter("projection", "With or without the convergence of parallels.", params.projection, {.words = "KIND"}),
        parameter("fov", "Vertical field of view of a perspective.", params.fieldOfView,
                  {.unit = "degrees", .limits = {kLeastFieldOfView, 180}}),
        parameter("view_height", "Height of an orthographic picture; by default all is seen.", params.viewHeight,
                  {.unit = "world", .limits = {0, 1e18, true}}),
        parameter("aperture",
                  "Diameter of the lens: what lies before or behind the target's distance is blurred. 0: all is sharp; "
                  "else give 16 `samples` or more.",
                  params.aperture, {.unit = "world", .limits = {0, 1e18}}),
    };
}

void CameraParams::validate() const
{
    const auto check = [](const char* name, const std::optional<glm::dvec3>& v) {
        if (v && !representable(*v))
            throw ParameterError(
                fmt::format("camera {} {} must be at most {}", name, vectorText(*v), kFarthestCoordinate));
    };
    check("eye", eye);
    check("target", target);
    check("up", up);
    if (up && !(glm::length(*up) > 0 && std::isfinite(glm::length(*up)))) {
        throw ParameterError(fmt::format("camera up {} must have a direction", vectorText(*up)));
    }
    if (eye && target && *eye == *target) {
        throw ParameterError(fmt::format("camera eye and target are the same place, {}", vectorText(*eye)));
    }
    CameraParams copy = *this;
    checkLimits(parametersOf(copy));
    if (fieldOfView >= 180) throw ParameterError(fmt::format("`fov` {} must be below 180 degrees", fieldOfView));
    if (viewHeight && projection == Projection::kPerspective) {
        throw ParameterError("a view height is for the orthographic projection; a perspective has a field of view");
    }
}

Camera::Camera(const CameraParams& params, const Corners& box, const glm::ivec2& size,
               std::span<const glm::dvec3> subject)
    : mSize(size), mProjection(params.projection), mUp(params.up.value_or(glm::dvec3(0, 0, 1))),
      mFieldOfView(params.fieldOfView), mLensRadius(params.aperture / 2), mArea{glm::ivec2(0), size}
{
    params.validate();
    const bool perspective = mProjection == Projection::kPerspective;
    mHalfExtent.y = perspective ? std::tan(glm::radians(mFieldOfView) / 2) : params.viewHeight.value_or(2) / 2;
    mHalfExtent.x = mHalfExtent.y * double(size.x) / double(size.y);
    const std::span<const glm::dvec3> points = subject.empty() ? std::span<const glm::dvec3>(box) : subject;

    mTarget = params.target.value_or(middleOf(box));
    checkDistance("target", mTarget, box);
    if (params.eye) {
        mEye = *params.eye;
        checkDistance("eye", mEye, box);
        if (mEye == mTarget) {
            throw ParameterError("camera eye is the middle of the volume, where it looks by default; give a target");
        }
    }
    const bool isChosen = !params.eye && !params.angles && params.view == ViewSide::kThreeQuarter;
    const glm::dvec2 angles = params.angles.value_or(anglesOf(params.view));
    const glm::dvec3 forward = params.eye ? glm::normalize(mTarget - mEye)
                               : isChosen ? chooseDirection(mProjection, box, mUp, mHalfExtent)
                                          : viewDirection(angles, mUp);
    if (parallel(forward, mUp)) {
        if (!params.eye) {
            mUp = viewDirection({0, angles.y}, mUp); // north is up in a map
        } else {
            if (params.up) throw ParameterError("the camera looks along its up direction; choose another up");
            mUp = {0, 1, 0};
        }
    }
    const glm::dmat3 axes = viewAxes(forward, mUp);
    const bool tight = !params.eye && !params.target;
    const Framing framing = tight ? frameTightly(mProjection, axes, points, mHalfExtent)
                                  : frameAround(mTarget, mProjection, axes, points, mHalfExtent);
    if (!params.eye) mEye = framing.eye;
    if (tight) mTarget = mEye + forward * glm::dot(forward, mTarget - mEye);
    if (!perspective && !params.viewHeight) mHalfExtent = framing.halfExtent;

    mCameraToWorld = glm::dmat4(axes);
    mCameraToWorld[3] = glm::dvec4(mEye, 1);
    mWorldToCamera = glm::dmat4(glm::transpose(axes));
    mWorldToCamera[3] = glm::dvec4(-(glm::transpose(axes) * mEye), 1);

    // By columns. x from −extent to extent becomes 0 to 1, y the same from the top; w is the depth, or 1 if
    // orthographic.
    glm::dmat4 cameraToNdc(0);
    cameraToNdc[0][0] = 0.5 / mHalfExtent.x;
    cameraToNdc[1][1] = -0.5 / mHalfExtent.y;
    const glm::dvec4 perDepth = perspective ? glm::dvec4(0.5, 0.5, 1, 1) : glm::dvec4(0, 0, 1, 0);
    const glm::dvec4 constant = perspective ? glm::dvec4(0, 0, -1, 0) : glm::dvec4(0.5, 0.5, 0, 1);
    cameraToNdc[2] = perDepth;
    cameraToNdc[3] = constant;
    mWorldToNdc = cameraToNdc * mWorldToCamera;
}

Camera Camera::shifted(const glm::dvec2& pixels) const
{
    Camera result = *this;
    result.mShift += pixels;
    return result;
}

Camera Camera::cropped(const PictureArea& area) const
{
    Camera result = *this;
    result.mArea = area;
    return result;
}

double Camera::pixelSize(const glm::dvec3& point) const
{
    const double distance = mProjection == Projection::kPerspective ? (mWorldToCamera * glm::dvec4(point, 1)).z : 1;
    return 2 * mHalfExtent.y / mSize.y * std::max(distance, 0.0);
}

PictureRays Camera::rays() const
{
    const glm::dmat3 axes(mCameraToWorld);
    const glm::dvec2 pitch = 2.0 * mHalfExtent / glm::dvec2(mSize), corner = mShift * pitch - mHalfExtent;
    const PictureGradient<glm::dvec3> offset{axes * glm::dvec3(corner.x, -corner.y, 0), axes[0] * pitch.x,
                                             axes[1] * -pitch.y};
    const glm::dvec3 none(0);
    if (mProjection == Projection::kOrthographic) {
        return {{mEye + offset.corner, offset.perX, offset.perY}, {axes[2], none, none}};
    }
    return {{mEye, none, none}, {axes[2] + offset.corner, offset.perX, offset.perY}};
}

std::optional<Lens> Camera::lens() const
{
    if (!(mLensRadius > 0)) return std::nullopt;
    const glm::dmat3 axes(mCameraToWorld);
    return Lens{axes[0] * mLensRadius, axes[1] * mLensRadius, 1 / glm::dot(mTarget - mEye, axes[2])};
}

Ray Camera::ray(const glm::dvec2& pixel) const
{
    const PictureRays all = rays();
    return {all.origin(pixel), glm::normalize(all.direction(pixel))};
}

} // namespace vdblic
