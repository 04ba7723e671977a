#include "vdblic/camera/clipping.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include <cmath>

namespace vdblic {
namespace {

bool finite(const glm::dvec3& v)
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

} // namespace

void ClipParams::validate() const
{
    for (const auto& [point, normal] : planes) {
        if (!finite(point) || !finite(normal) || !(glm::length(normal) > 0)) {
            throw ParameterError(
                fmt::format("clip plane {} {} {}  {} {} {} must be a point and a normal that is not zero", point.x,
                            point.y, point.z, normal.x, normal.y, normal.z));
        }
    }
    if (!box) return;
    const auto& [low, high] = *box;
    if (!finite(low) || !finite(high) || !(low.x < high.x && low.y < high.y && low.z < high.z)) {
        throw ParameterError(fmt::format("clip box {} {} {}  {} {} {} must be a low and a high corner", low.x, low.y,
                                         low.z, high.x, high.y, high.z));
    }
}

std::vector<ClipPlane> ClipParams::allPlanes() const
{
    std::vector<ClipPlane> all = planes;
    if (!box) return all;
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 inward(0);
        inward[axis] = 1;
        all.push_back({(*box)[0], inward});
        all.push_back({(*box)[1], -inward});
    }
    return all;
}

ClipParams ClipParams::stretched(const glm::dvec3& factors) const
{
    ClipParams result = *this;
    for (auto& [point, normal] : result.planes) {
        point *= factors;
        normal /= factors;
    }
    if (result.box) {
        for (glm::dvec3& corner : *result.box)
            corner *= factors;
    }
    return result;
}

} // namespace vdblic
