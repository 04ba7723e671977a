#pragma once

#include "vdblic/image/cairo_drawing.h"
#include "vdblic/look/transfer_function.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <string>

namespace vdblic {

/// Draw the names of kinds at the left of their colours, one below the other in the order of their numbers, and what is
/// of no kind last.
/// @param corner top right [pixels]  @param textSize of the canvas's font [pixels]
/// @return the lower end of the drawing
double drawLegend(const CairoCanvas& canvas, const glm::dvec2& corner, double textSize, const std::string& title,
                  const TransferFunction& transfer, const glm::dvec3& ink);

} // namespace vdblic
