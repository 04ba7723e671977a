#include "vdblic/cast/ground.h"

#include "vdblic/camera/camera.h"
#include "vdblic/cast/depth_cue.h"
#include "vdblic/cast/pixel_rays.h"
#include "vdblic/cast/surface_picture.h"
#include "vdblic/look/look.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vdblic {
namespace {

/// A background's colour, or a lighter one, with a touch of its hue, if it is so dark that a shadow on it would not be
/// seen. @param color linear
glm::vec3 lightened(const glm::vec3& color)
{
    constexpr float kLeast = 0.075f, kTint = 0.35f, kDarkest = 1e-4f;
    const glm::vec3 kLuminance(0.2126f, 0.7152f, 0.0722f);
    const float luminance = glm::dot(color, kLuminance), missing = std::max(kLeast - luminance, 0.0f);
    const glm::vec3 hue = (color + kDarkest) / (luminance + kDarkest);
    return color + missing * glm::mix(glm::vec3(1), hue, kTint);
}

} // namespace

void Ground::addTo(SurfacePicture& picture, const PlacedBox& box, const Look& look, const Camera& camera, int ray,
                   const std::uint8_t* only) const
{
    const PixelRays rays(camera, ray);
    const DepthCue cue(box, look, camera);
    const std::vector<glm::vec3> background = look.backgroundRows(camera.size().y);
    const auto exposure = float(std::exp2(look.exposure)); // divided out of the ground's colour: applied after the rays
    const PictureArea& area = camera.area();
    tbb::parallel_for(area.low.y, area.high.y, [&](int y) {
        const glm::vec3& behind = background[std::size_t(y)];
        const glm::vec3 color = lightened(behind * exposure) / exposure;
        for (int x = area.low.x; x < area.high.x; ++x) {
            const std::size_t i = std::size_t(y) * std::size_t(camera.size().x) + std::size_t(x);
            if (std::isfinite(picture.depths[i]) || (only && !only[i])) continue;
            const auto [origin, direction] = rays.at(x, y);
            const double above = glm::dot(origin, mPlane.normal) - mPlane.height;
            const double slope = glm::dot(direction, mPlane.normal);
            if (!(above > 0 && slope < 0)) continue;
            const double depth = -above / slope;
            const glm::dvec3 at = origin + direction * depth;
            const glm::dvec2 place(glm::dot(at, mPlane.axes[0]), glm::dot(at, mPlane.axes[1]));
            const auto alpha = float(mPlane.alpha(place));
            if (!(alpha > 0)) continue;
            const glm::vec3 seen = glm::mix(color * mLight.at(place), behind, cue.share(float(depth)));
            picture.depths[i] = float(depth);
            picture.colors[i] = glm::vec4(seen, 1) * alpha;
            picture.normals[i] = glm::vec3(mPlane.normal);
        }
    });
}

} // namespace vdblic
