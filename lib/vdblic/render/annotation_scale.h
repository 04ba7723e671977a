#pragma once

#include "vdblic/camera/camera.h"
#include "vdblic/image/cairo_drawing.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <string>

namespace vdblic {

/// A horizontal bar in the picture and the length that it represents.
struct ScaleBar {
    double length; ///< in the data's world; 1, 2 or 5 times a power of ten
    double width;  ///< [pixels]; up to a fifth of the picture's
};
/// In a perspective picture lengths hold at the target's distance from the eye's plane.
/// @param stretch of the picture's world
[[nodiscard]] ScaleBar scaleBar(const Camera& camera, const glm::dvec3& stretch);

/// Draw a bar with its length over it. @param corner lower left [pixels]  @param unit of the world; empty: unknown
/// @return the upper end of the drawing
double drawScaleBar(const CairoCanvas& canvas, const glm::dvec2& corner, double textSize, const ScaleBar& bar,
                    const std::string& unit);

/// Names of the world's axes.
using AxisNames = std::array<std::string, 3>;

/// Draw the directions of the world's axes at the target. @param corner lower left [pixels]
/// @return the upper end of the drawing
double drawTriad(const CairoCanvas& canvas, const glm::dvec2& corner, double textSize, const Camera& camera,
                 const AxisNames& names);

} // namespace vdblic
