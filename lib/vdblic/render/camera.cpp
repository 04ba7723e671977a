#include "vdblic/render/camera.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

#include <algorithm>
#include <cmath>

namespace vdblic {
namespace {

// The three-quarter view: from the front, to the right of it and above.
constexpr double kAzimuth = 30, kElevation = 25; // degrees
constexpr double kMargin = 1.04;

// Beyond it squares of lengths leave single precision.
constexpr double kFarthest = 1e18;

bool finite(const glm::dvec3& v)
{
    return std::abs(v.x) <= kFarthest && std::abs(v.y) <= kFarthest && std::abs(v.z) <= kFarthest;
}

bool parallel(const glm::dvec3& a, const glm::dvec3& b)
{
    return glm::length(glm::cross(a, b)) < 1e-9 * glm::length(a) * glm::length(b);
}

/// The direction the three-quarter view looks in.
glm::dvec3 defaultForward(const glm::dvec3& up)
{
    const glm::dvec3 top = glm::normalize(up);
    const glm::dvec3 side = parallel(up, {1, 0, 0}) ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 away = glm::normalize(glm::cross(top, side));
    const glm::dvec3 right = glm::cross(away, top);
    const double azimuth = glm::radians(kAzimuth), elevation = glm::radians(kElevation);
    return std::cos(elevation) * (std::cos(azimuth) * away - std::sin(azimuth) * right) - std::sin(elevation) * top;
}

/// x right, y up, z forward, as the columns of a rotation.
glm::dmat3 axes(const glm::dvec3& forward, const glm::dvec3& up)
{
    const glm::dvec3 right = glm::normalize(glm::cross(forward, up));
    return {right, glm::cross(right, forward), forward};
}

/// How far back a camera must stand from the target to see every corner.
double fittingDistance(const glm::dmat3& view, const glm::dvec3& target, const Corners& corners,
                       const glm::dvec2& halfExtent)
{
    double distance = 0;
    for (const glm::dvec3& corner : corners) {
        const glm::dvec3 local = glm::transpose(view) * (corner - target);
        distance = std::max({distance, kMargin * std::abs(local.x) / halfExtent.x - local.z,
                             kMargin * std::abs(local.y) / halfExtent.y - local.z});
    }
    return distance > 0 ? distance : 1;
}

} // namespace

void CameraParams::validate() const
{
    const auto check = [](const char* name, const std::optional<glm::dvec3>& v) {
        if (v && !finite(*v))
            throw ParameterError(fmt::format("camera {} {} {} {} must be at most {}", name, v->x, v->y, v->z, kFarthest));
    };
    check("eye", eye);
    check("target", target);
    check("up", up);
    if (up && !(glm::length(*up) > 0)) throw ParameterError("camera up must not be the zero vector");
    if (eye && target && *eye == *target) {
        throw ParameterError(fmt::format("camera eye and target are the same place, {} {} {}", eye->x, eye->y, eye->z));
    }
    if (!(fieldOfView > 0 && fieldOfView < 180)) {
        throw ParameterError(fmt::format("field of view {} must be between 0 and 180 degrees", fieldOfView));
    }
}

Camera::Camera(const CameraParams& params, const Corners& corners, const glm::ivec2& size)
    : mSize(size), mUp(params.up.value_or(glm::dvec3(0, 0, 1))), mFieldOfView(params.fieldOfView)
{
    params.validate();
    glm::dvec3 middle(0);
    for (const glm::dvec3& corner : corners)
        middle += corner / 8.0;
    mTarget = params.target.value_or(middle);
    mHalfExtent.y = std::tan(glm::radians(mFieldOfView) / 2);
    mHalfExtent.x = mHalfExtent.y * double(size.x) / double(size.y);

    if (params.eye && *params.eye == mTarget) {
        throw ParameterError("camera eye is the middle of the volume, where it looks by default; give a target too");
    }
    const glm::dvec3 forward = params.eye ? glm::normalize(mTarget - *params.eye) : defaultForward(mUp);
    if (parallel(forward, mUp)) {
        if (params.up) throw ParameterError("the camera looks along its up direction; choose another up");
        mUp = {0, 1, 0};
    }
    const glm::dmat3 view = axes(forward, mUp);
    mEye = params.eye ? *params.eye : mTarget - forward * fittingDistance(view, mTarget, corners, mHalfExtent);

    mCameraToWorld = glm::dmat4(view);
    mCameraToWorld[3] = glm::dvec4(mEye, 1);
    mWorldToCamera = glm::dmat4(glm::transpose(view));
    mWorldToCamera[3] = glm::dvec4(-(glm::transpose(view) * mEye), 1);

    // Columns: x/z from −extent to extent becomes 0 to 1, y the other way round, w is the depth.
    glm::dmat4 cameraToNdc(0);
    cameraToNdc[0][0] = 0.5 / mHalfExtent.x;
    cameraToNdc[1][1] = -0.5 / mHalfExtent.y;
    cameraToNdc[2] = {0.5, 0.5, 1, 1};
    cameraToNdc[3][2] = -1;
    mWorldToNdc = cameraToNdc * mWorldToCamera;
}

Ray Camera::ray(const glm::dvec2& pixel) const
{
    const glm::dvec2 place = (pixel / glm::dvec2(mSize) * 2.0 - 1.0) * mHalfExtent;
    return {mEye, glm::normalize(glm::dmat3(mCameraToWorld) * glm::dvec3(place.x, -place.y, 1))};
}

} // namespace vdblic
