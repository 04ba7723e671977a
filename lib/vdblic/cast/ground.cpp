#include "vdblic/cast/ground.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include <algorithm>

namespace vdblic {

std::optional<Ground::Point> Ground::at(const glm::dvec3& origin, const glm::dvec3& direction) const
{
    const double above = glm::dot(origin, mPlane.normal) - mPlane.height, slope = glm::dot(direction, mPlane.normal);
    if (!(above > 0 && slope < 0)) return std::nullopt;
    const double depth = -above / slope;
    const glm::dvec3 at = origin + direction * depth;
    const glm::dvec2 place(glm::dot(at, mPlane.axes[0]), glm::dot(at, mPlane.axes[1]));
    const auto alpha = float(mPlane.alpha(place));
    if (!(alpha > 0)) return std::nullopt;
    return Point{depth, mLight.at(place), alpha};
}

glm::vec3 Ground::color(const glm::vec3& background)
{
    constexpr float kLeast = 0.075f, kTint = 0.35f, kDarkest = 1e-4f;
    const glm::vec3 kLuminance(0.2126f, 0.7152f, 0.0722f);
    const float luminance = glm::dot(background, kLuminance), missing = std::max(kLeast - luminance, 0.0f);
    const glm::vec3 hue = (background + kDarkest) / (luminance + kDarkest);
    return background + missing * glm::mix(glm::vec3(1), hue, kTint);
}

} // namespace vdblic
