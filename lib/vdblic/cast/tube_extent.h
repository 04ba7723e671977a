#pragma once

#include <glm/vec3.hpp>

#include <vector>

namespace vdblic {

class ExtinctionGrid;
class Tubes;
struct ClipParams;

/// World-space points around the visible tubes: a hundred of the outermost corners of their light's cells. Cells
/// that are almost transparent or cut away do not count.
/// @param visible of the tubes under the look  @param clip in the tubes' world space
[[nodiscard]] std::vector<glm::dvec3> visibleExtent(const Tubes& tubes, const ExtinctionGrid& visible,
                                                    const ClipParams& clip);

} // namespace vdblic
