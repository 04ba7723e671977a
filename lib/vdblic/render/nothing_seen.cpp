#include "vdblic/render/nothing_seen.h"

#include "vdblic/core/exchange.h"

#include <fmt/format.h>
#include <glm/vec4.hpp>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace vdblic {
namespace {

/// Whether all corners lie outside of one side of the picture, or behind the eye.
bool isBesidePicture(const Corners& box, const Camera& camera)
{
    const bool perspective = camera.projection() == Projection::kPerspective;
    const auto allAre = [&](const auto& outside) {
        return std::all_of(box.begin(), box.end(), [&](const glm::dvec3& corner) {
            const glm::dvec4 at = camera.worldToCamera() * glm::dvec4(corner, 1);
            return outside(at, camera.halfExtent() * (perspective ? at.z : 1.0));
        });
    };
    using Vec2 = glm::dvec2;
    using Vec4 = glm::dvec4;
    return allAre([](const Vec4& at, const Vec2&) { return at.z <= 0; }) ||
           allAre([](const Vec4& at, const Vec2& edge) { return at.x > edge.x; }) ||
           allAre([](const Vec4& at, const Vec2& edge) { return at.x < -edge.x; }) ||
           allAre([](const Vec4& at, const Vec2& edge) { return at.y > edge.y; }) ||
           allAre([](const Vec4& at, const Vec2& edge) { return at.y < -edge.y; });
}

std::string textOf(const glm::dvec3& v)
{
    return fmt::format("{:.6g} {:.6g} {:.6g}", v.x, v.y, v.z);
}

} // namespace

std::string whyNothingIsSeen(const LoadedTexture& frame, const Look& look, const Camera& camera,
                             const RayCastParams& rays, Exchange& exchange)
{
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    double ends[] = {-kInfinity, -kInfinity, 0}; // the low end's negative, the high end, and whether there are any
    const auto add = [&](const LeafRange& range) {
        ends[0] = std::max(ends[0], -double(range.lowDriver));
        ends[1] = std::max(ends[1], double(range.highDriver));
        ends[2] = 1;
    };
    for (std::size_t leaf = 0; frame.volume && leaf < frame.volume->leafCount(); ++leaf) {
        if (!frame.volume->shown(leaf).isOff()) add(frame.volume->leafRange(leaf));
    }
    if (frame.tubes && !frame.empty()) add(frame.tubes->range());
    exchange.max(ends);
    const double low = -ends[0], high = ends[1];
    if (ends[2] == 0) return "no active voxel is left to show; check the grid, `roi` and `roi_box`";
    const Corners box = frame.box().corners();
    if (isCutAway(box, rays.clip.allPlanes())) {
        return fmt::format("`clip_box` or `clip_plane` cut everything away, which lies from {} to {}",
                           textOf(box.front()), textOf(box.back()));
    }
    if (isBesidePicture(box, camera)) {
        return fmt::format("the camera at {} looks at {} and sees nothing of what lies from {} to {}; change `eye` and "
                           "`target`, or leave them out",
                           textOf(camera.eye()), textOf(camera.target()), textOf(box.front()), textOf(box.back()));
    }
    const auto& range = look.transfer.opacityRange();
    if (high < range[0] || low > range[1]) {
        return fmt::format("the values, {:.6g} to {:.6g}, lie outside of `{}` {:.6g} to {:.6g}", low, high,
                           range == look.transfer.range() ? "range" : "opacity_range", range[0], range[1]);
    }
    return "every sample is transparent; raise `opacity`";
}

} // namespace vdblic
