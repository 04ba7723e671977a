#pragma once

#include "vdblic/image/cairo_drawing.h"
#include "vdblic/look/scalar_axis.h"
#include "vdblic/render/annotations.h"

#include <string>
#include <vector>

namespace vdblic {

/// Draw the outline of a box. @param far the edges at its back, else those at its front
void drawBox(const CairoCanvas& canvas, const Corners& box, const Camera& camera, bool far);

/// Draw ticks with numbers in world units along an edge of the box for each axis, outside its picture.
/// @param textSize [pixels]
void drawAxes(const CairoCanvas& canvas, const Corners& box, const glm::dvec3& stretch, const Camera& camera,
              double textSize);

/// Round numbers between two bounds, about `wanted` of them. @param step receives their distance
[[nodiscard]] std::vector<double> roundNumbers(double low, double high, int wanted, double& step);
/// A number with as many decimals as its step needs.
[[nodiscard]] std::string tickText(double value, double step);

/// A mark on a scale.
struct Tick {
    double value;
    std::string text;
};
/// Marks at round numbers of an axis, about `wanted` of them; on a logarithmic one at powers of ten, or also at 2 and 5
/// times these, if its range holds a few.
[[nodiscard]] std::vector<Tick> ticks(const ScalarAxis& axis, int wanted);

} // namespace vdblic
