#pragma once

#include <glm/vec3.hpp>

#include <vector>

namespace vdblic {

struct Solid;

/// Points around a solid, in the picture's world: corners of parts of its surface, about a thousand of the outermost;
/// nothing without a surface.
[[nodiscard]] std::vector<glm::dvec3> solidExtent(const Solid& solid);

} // namespace vdblic
