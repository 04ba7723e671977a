#include "vdblic/camera/framing.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace vdblic {
namespace {

constexpr double kMargin = 1.08;   // the picture's size over the subject's
constexpr double kClearance = 0.1; // in front of the nearest point, in sizes of the whole
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Elevation and azimuth [degrees]. The first view that fills the picture well is chosen.
constexpr glm::dvec2 kViews[] = {{25, 30}, {25, 60}, {45, 30}, {45, 60}, {60, 30}, {60, 60}};
/// Views of a box that lies flat. North is up unless another side fills the picture much better.
constexpr glm::dvec2 kMapViews[] = {{52, 0}, {52, 90}};
/// Share of the best view's coverage that counts as well.
constexpr double kWell = 0.7;
/// Views of a plate, which is invisible from the side. The best one is chosen.
constexpr glm::dvec2 kPlateViews[] = {{80, 0}, {10, 0}, {10, 90}};

/// The share of the picture that a box covers: half the sum of its faces' areas there, since a convex body covers each
/// point of its outline twice.
double coverage(Projection projection, const glm::dmat3& axes, const Corners& box, const Framing& framing)
{
    std::array<glm::dvec2, 8> seen;
    for (std::size_t i = 0; i < 8; ++i) {
        const glm::dvec3 local = glm::transpose(axes) * (box[i] - framing.eye);
        seen[i] = glm::dvec2(local) / framing.halfExtent;
        if (projection == Projection::kPerspective) seen[i] /= local.z;
    }
    const auto cross = [](const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; };
    double area = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t across = std::size_t(1) << (axis + 1) % 3, along = std::size_t(1) << (axis + 2) % 3;
        for (std::size_t side : {std::size_t(0), std::size_t(1) << axis}) {
            // A quadrangle's area from its diagonals.
            area +=
                std::abs(cross(seen[side + across + along] - seen[side], seen[side + along] - seen[side + across])) / 2;
        }
    }
    return area / 2 / 4;
}

/// Whether a box is thinner than an eighth of its other two edges.
bool isPlate(const Corners& box)
{
    constexpr double kThin = 8;
    std::array<double, 3> edges = {glm::distance(box[0], box[1]), glm::distance(box[0], box[2]),
                                   glm::distance(box[0], box[4])};
    std::sort(edges.begin(), edges.end());
    return kThin * edges[0] < edges[1];
}

/// Whether a box lies flat: its edge along `up` is much shorter than the other two.
bool liesFlat(const Corners& box, const glm::dvec3& up)
{
    constexpr double kFlat = 2.5;
    double height = 0, least = kInfinity;
    for (const std::size_t corner : {1, 2, 4}) {
        const glm::dvec3 edge = box[corner] - box[0];
        const double length = glm::length(edge);
        if (std::abs(glm::dot(edge, glm::normalize(up))) > 0.99 * length) {
            height = length;
        } else {
            least = std::min(least, length);
        }
    }
    return height > 0 && kFlat * height < least;
}

/// The coordinate of a perspective eye, between two bounds, for which the points reach as far to one side of the
/// picture as to the other.
double centredEye(const std::vector<glm::dvec3>& points, int axis, double eyeDepth, double least, double most)
{
    constexpr int kHalvings = 60;
    for (int i = 0; i < kHalvings; ++i) {
        const double eye = (least + most) / 2;
        double first = kInfinity, last = -kInfinity;
        for (const glm::dvec3& point : points) {
            const double seen = (point[axis] - eye) / (point.z - eyeDepth);
            first = std::min(first, seen);
            last = std::max(last, seen);
        }
        (first + last > 0 ? least : most) = eye;
    }
    return (least + most) / 2;
}

/// Distance of an orthographic eye in front of a point, such that all other points are in front of the eye.
double clearance(const glm::dvec3& from, const glm::dmat3& axes, std::span<const glm::dvec3> points)
{
    double before = 0, most = 0;
    for (const glm::dvec3& point : points) {
        before = std::max(before, -glm::dot(axes[2], point - from));
        most = std::max(most, glm::length(point - from));
    }
    return before + (most > 0 ? most : 1);
}

} // namespace

glm::dmat3 viewAxes(const glm::dvec3& forward, const glm::dvec3& up)
{
    const glm::dvec3 right = glm::normalize(glm::cross(forward, up));
    return {right, glm::cross(right, forward), forward};
}

glm::dvec3 viewDirection(const glm::dvec2& angles, const glm::dvec3& up)
{
    const glm::dvec3 top = glm::normalize(up);
    const bool alongX = glm::length(glm::cross(top, {1, 0, 0})) < 1e-9;
    const glm::dvec3 away = glm::normalize(glm::cross(top, alongX ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0)));
    const glm::dvec3 right = glm::cross(away, top);
    const double elevation = glm::radians(angles.x), azimuth = glm::radians(angles.y);
    return std::cos(elevation) * (std::cos(azimuth) * away - std::sin(azimuth) * right) - std::sin(elevation) * top;
}

Framing frameTightly(Projection projection, const glm::dmat3& axes, std::span<const glm::dvec3> points,
                     const glm::dvec2& halfExtent)
{
    const glm::dvec2 extent = halfExtent / kMargin;
    const bool perspective = projection == Projection::kPerspective;
    std::vector<glm::dvec3> local;
    for (const glm::dvec3& point : points)
        local.push_back(glm::transpose(axes) * point);
    glm::dvec2 low(-kInfinity), high(-kInfinity);
    double nearest = kInfinity, size = 0;
    for (const glm::dvec3& point : local) {
        const glm::dvec2 spread = perspective ? extent * point.z : glm::dvec2(0);
        low = glm::max(low, -glm::dvec2(point) - spread);
        high = glm::max(high, glm::dvec2(point) - spread);
        nearest = std::min(nearest, point.z);
        size = std::max(size, glm::distance(point, local[0]));
    }
    const glm::dvec2 middle = (high - low) / 2.0, half = (high + low) / 2.0;
    if (perspective) {
        // In a wide angle a corner fills the picture from any distance, hence the clearance.
        const double clear = size > 0 ? kClearance * size - nearest : 1 - nearest;
        const double back = std::max({half.x / extent.x, half.y / extent.y, clear});
        glm::dvec3 eye(0, 0, -back);
        for (int axis = 0; axis < 2; ++axis)
            eye[axis] =
                centredEye(local, axis, eye.z, high[axis] - extent[axis] * back, extent[axis] * back - low[axis]);
        return {axes * eye, halfExtent};
    }
    double scale = std::max(half.x / extent.x, half.y / extent.y);
    if (!(scale > 0)) scale = 1;
    const glm::dvec3 center = axes * glm::dvec3(middle, local[0].z);
    return {center - axes[2] * clearance(center, axes, points), halfExtent * scale};
}

Framing frameAround(const glm::dvec3& target, Projection projection, const glm::dmat3& axes,
                    std::span<const glm::dvec3> points, const glm::dvec2& halfExtent)
{
    const glm::dvec2 extent = halfExtent / kMargin;
    double back = 0, scale = 0;
    for (const glm::dvec3& point : points) {
        const glm::dvec3 local = glm::transpose(axes) * (point - target);
        const double needed = std::max(std::abs(local.x) / extent.x, std::abs(local.y) / extent.y);
        back = std::max(back, needed - local.z);
        scale = std::max(scale, needed);
    }
    if (projection == Projection::kPerspective) return {target - axes[2] * (back > 0 ? back : 1), halfExtent};
    return {target - axes[2] * clearance(target, axes, points), halfExtent * (scale > 0 ? scale : 1)};
}

glm::dvec3 chooseDirection(Projection projection, const Corners& box, const glm::dvec3& up,
                           const glm::dvec2& halfExtent)
{
    const bool plate = isPlate(box), map = !plate && liesFlat(box, up);
    const std::span<const glm::dvec2> views = plate ? std::span<const glm::dvec2>(kPlateViews)
                                              : map ? std::span<const glm::dvec2>(kMapViews)
                                                    : kViews;
    const auto filled = [&](const glm::dvec2& angles) {
        const glm::dmat3 axes = viewAxes(viewDirection(angles, up), up);
        return coverage(projection, axes, box, frameTightly(projection, axes, box, halfExtent));
    };
    std::vector<double> shares(views.size());
    std::transform(views.begin(), views.end(), shares.begin(), filled);
    const auto best = std::max_element(shares.begin(), shares.end());
    const double enough = plate ? *best : kWell * *best;
    const auto first = std::find_if(shares.begin(), shares.end(), [&](double share) { return share >= enough; });
    return viewDirection(first == shares.end() ? views[0] : views[std::size_t(first - shares.begin())], up);
}

} // namespace vdblic
