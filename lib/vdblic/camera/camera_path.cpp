#include "vdblic/camera/camera_path.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace vdblic {
namespace {

constexpr double kMostTurns = 1e6;
constexpr std::size_t kOrbitViews = 64; // all must be seen in each of them when the distance is chosen

/// Rotation about an axis through the origin.
glm::dmat3 rotation(const glm::dvec3& axis, double angle)
{
    return {glm::rotate(glm::dmat4(1), angle, axis)};
}

/// The middle of the bounds of points.
glm::dvec3 middleOfBounds(const std::vector<glm::dvec3>& points)
{
    glm::dvec3 low = points.front(), high = low;
    for (const glm::dvec3& point : points) {
        low = glm::min(low, point);
        high = glm::max(high, point);
    }
    return (low + high) / 2.0;
}

/// The points in all views of a camera that orbits them, relative to the first one. @param turns at most one either way
std::vector<glm::dvec3> turned(const std::vector<glm::dvec3>& subject, const glm::dvec3& middle, const glm::dvec3& axis,
                               double turns)
{
    std::vector<glm::dvec3> points;
    for (std::size_t i = 0; i < kOrbitViews; ++i) {
        const glm::dmat3 turn = rotation(axis, -2 * std::numbers::pi * turns * double(i) / (kOrbitViews - 1));
        for (const glm::dvec3& point : subject)
            points.push_back(middle + turn * (point - middle));
    }
    return points;
}

} // namespace

template<typename Value>
Value CameraTrack<Value>::slope(std::size_t key) const
{
    const auto secant = [&](std::size_t i) {
        return (mKeys[i + 1].second - mKeys[i].second) / double(mKeys[i + 1].first - mKeys[i].first);
    };
    if (mKeys.size() < 2) return Value(0);
    if (key == 0) return secant(0);
    if (key + 1 == mKeys.size()) return secant(key - 1);
    const Value before = secant(key - 1), after = secant(key);
    if (before == Value(0) || after == Value(0)) return Value(0);
    const auto left = double(mKeys[key].first - mKeys[key - 1].first);
    const auto right = double(mKeys[key + 1].first - mKeys[key].first);
    return (before * right + after * left) / (left + right); // the parabola through the three keys
}

template<typename Value>
Value CameraTrack<Value>::at(double frame) const
{
    const auto after = std::upper_bound(mKeys.begin(), mKeys.end(), frame,
                                        [](double f, const auto& key) { return f < double(key.first); });
    if (after == mKeys.begin()) return mKeys.front().second;
    if (after == mKeys.end()) return mKeys.back().second;
    const auto i = std::size_t(after - mKeys.begin()) - 1;
    const auto length = double(mKeys[i + 1].first - mKeys[i].first);
    const double t = (frame - double(mKeys[i].first)) / length, s = 1 - t;
    const Value& start = mKeys[i].second;
    return start + (mKeys[i + 1].second - start) * (t * t * (3 - 2 * t)) + slope(i) * (length * t * s * s) -
           slope(i + 1) * (length * t * t * s);
}

template class CameraTrack<double>;
template class CameraTrack<glm::dvec3>;

bool CameraKeys::empty() const
{
    return eye.empty() && target.empty() && up.empty() && fieldOfView.empty() && viewHeight.empty();
}

CameraParams CameraKeys::applied(CameraParams params, double frame) const
{
    if (!eye.empty()) params.eye = eye.at(frame);
    if (!target.empty()) params.target = target.at(frame);
    if (!up.empty()) params.up = up.at(frame);
    if (!fieldOfView.empty()) params.fieldOfView = fieldOfView.at(frame);
    if (!viewHeight.empty()) params.viewHeight = viewHeight.at(frame);
    return params;
}

Parameters parametersOf(CameraMotion& params)
{
    return {
        parameter("orbit",
                  "Turns of the camera around the target in the course of the sequence; the last frame ends one step "
                  "before the first begins again.",
                  params.orbit, {.unit = "turns", .limits = {-kMostTurns, kMostTurns}}),
        parameter("orbit_frames",
                  "Frames that the turns take, instead of those on disk; needed for paths on standard input, where "
                  "frame 1 is the first.",
                  params.orbitFrames, {.limits = {.least = 1}}),
    };
}

void CameraMotion::validate() const
{
    CameraMotion copy = *this;
    checkLimits(parametersOf(copy));
    if (orbitFrames && orbit == 0) throw ParameterError("the frames of an orbit are given, but not its turns");
    if (orbit != 0 && !keys.empty()) {
        throw ParameterError("the camera can follow key frames or an orbit, not both");
    }
}

CameraPath::CameraPath(const CameraParams& params, const CameraMotion& motion, const Corners& box,
                       const glm::ivec2& size, const FrameSpan& span, std::vector<glm::dvec3> subject)
    : mParams(params), mKeys(motion.keys), mBox(box), mSize(size), mSpan(span), mOrbit(motion.orbit)
{
    if (motion.orbitFrames) mSpan.length = *motion.orbitFrames;

    // Unset members are chosen for the first frame and stay.
    CameraParams first = mKeys.applied(params, double(span.first));
    if (mOrbit != 0) {
        if (subject.empty()) subject.assign(box.begin(), box.end());
        if (!first.target) first.target = middleOfBounds(subject);
        subject = turned(subject, *first.target, first.up.value_or(glm::dvec3(0, 0, 1)), std::clamp(mOrbit, -1.0, 1.0));
    }
    const Camera chosen(first, box, size, subject);
    mParams.eye = chosen.eye();
    mParams.target = chosen.target();
    mParams.up = chosen.up();
    if (mParams.projection == Projection::kOrthographic) mParams.viewHeight = 2 * chosen.halfExtent().y;
}

Camera CameraPath::at(double frame) const
{
    CameraParams params = mKeys.applied(mParams, frame);
    if (mOrbit != 0) {
        const double turns = mOrbit * (frame - double(mSpan.first)) / double(mSpan.length);
        const double angle = 2 * std::numbers::pi * (turns - std::floor(turns));
        params.eye = *params.target + rotation(*params.up, angle) * (*params.eye - *params.target);
    }
    try {
        return {params, mBox, mSize};
    } catch (const ParameterError& error) {
        if (mKeys.empty()) throw;
        throw ParameterError(fmt::format("frame {}: {}", frame, error.what()));
    }
}

} // namespace vdblic
