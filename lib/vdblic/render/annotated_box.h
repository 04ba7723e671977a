#pragma once

#include "vdblic/image/cairo_drawing.h"
#include "vdblic/look/scalar_axis.h"
#include "vdblic/render/annotation_labels.h"
#include "vdblic/render/annotation_texts.h"
#include "vdblic/render/annotations.h"

#include <string>
#include <vector>

namespace vdblic {

/// Draw the outline of a box. @param far the edges at its back, else those at its front
void drawBox(const CairoCanvas& canvas, const Corners& box, const Camera& camera, bool far);

/// Draw ticks with numbers in world units along an edge of the box for each axis, outside its picture: as many as there
/// is room for.
/// @param lengthUnit of the world; empty: unknown  @param textSize [pixels]
void drawAxes(const CairoCanvas& canvas, Labels& labels, const Corners& box, const glm::dvec3& stretch,
              const std::string& lengthUnit, const Camera& camera, double textSize);

/// A mark on a scale.
struct Tick {
    double value;
    std::string text;
};
/// Marks at round numbers of an axis, about `wanted` of them; on a logarithmic one at powers of ten, or also at 2 and 5
/// times these, if its range holds a few.
[[nodiscard]] std::vector<Tick> ticks(const ScalarAxis& axis, int wanted);

} // namespace vdblic
