#include "vdblic/render/annotation_scale.h"

#include "vdblic/camera/framing.h"
#include "vdblic/render/annotation_texts.h"

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vdblic {
namespace {

glm::dmat3 viewOf(const Camera& camera)
{
    return viewAxes(glm::normalize(camera.target() - camera.eye()), camera.up());
}

} // namespace

ScaleBar scaleBar(const Camera& camera, const glm::dvec3& stretch)
{
    constexpr double kMostShare = 0.2;
    const bool perspective = camera.projection() == Projection::kPerspective;
    const double distance = perspective ? glm::length(camera.target() - camera.eye()) : 1;
    const double perPixel = 2 * camera.halfExtent().x * distance / camera.size().x *
                            glm::length(viewOf(camera)[0] / stretch); // in the data's world
    const double most = kMostShare * camera.size().x * perPixel;
    const double power = std::pow(10, std::floor(std::log10(most) + 1e-9)), share = most / power;
    const double length = power * (share >= 5 ? 5 : share >= 2 ? 2 : 1);
    return {length, length / perPixel};
}

double drawScaleBar(const CairoCanvas& canvas, const glm::dvec2& corner, double textSize, const ScaleBar& bar,
                    const std::string& unit)
{
    const double tick = 0.35 * textSize, left = corner.x, right = left + bar.width, y = corner.y - tick;
    canvas.drawLine({left, y}, {right, y});
    canvas.drawLine({left, y - tick}, {left, y + tick});
    canvas.drawLine({right, y - tick}, {right, y + tick});
    const double baseline = y - 0.7 * textSize;
    const std::string text = lengthText(bar.length, unit);
    cairo_text_extents_t extents;
    cairo_text_extents(canvas.context(), text.c_str(), &extents);
    // A text that is longer than the bar begins with it: it would leave the picture.
    if (extents.x_advance < bar.width) {
        canvas.drawText({(left + right) / 2, baseline}, 0.5, text);
    } else {
        canvas.drawText({left, baseline}, 0, text);
    }
    return baseline - textSize;
}

double drawTriad(const CairoCanvas& canvas, const glm::dvec2& corner, double textSize, const Camera& camera,
                 const AxisNames& names)
{
    constexpr double kArm = 2.4, kName = 3.2; // from the middle, in sizes of the text
    const glm::dmat3 toView = glm::transpose(viewOf(camera));
    const glm::dvec2 middle = corner + glm::dvec2(kName + 0.8, -kName - 0.6) * textSize;
    std::array<int, 3> order = {0, 1, 2}; // the farthest first
    std::sort(order.begin(), order.end(), [&](int a, int b) { return toView[a].z > toView[b].z; });
    for (const int axis : order) {
        const glm::dvec2 arm(toView[axis].x, -toView[axis].y);
        const double length = glm::length(arm);
        canvas.drawLine(middle, middle + kArm * textSize * arm);
        if (length < 0.1) continue; // it points at the eye: a name would be on the others'
        const glm::dvec2 tip = middle + kArm * textSize * arm, along = arm / length;
        const glm::dvec2 across(-along.y, along.x), foot = tip - 0.5 * textSize * along;
        for (const double side : {-0.22, 0.22})
            canvas.drawLine(tip, foot + side * textSize * across);
        const glm::dvec2 name = tip + (kName - kArm) * textSize * along;
        canvas.drawText({name.x, name.y + 0.36 * textSize}, 0.5, names[std::size_t(axis)]);
    }
    return middle.y - (kName + 0.6) * textSize;
}

} // namespace vdblic
