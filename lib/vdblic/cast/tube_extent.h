#pragma once

#include <glm/vec3.hpp>

#include <vector>

namespace vdblic {

class ExtinctionGrid;
class Tubes;
struct ClipParams;

/// Points around what a look shows of tubes, in world space: corners of cells of their light, a hundred of the
/// outermost. Cells that are almost transparent or cut away do not count.
/// @param visible of the tubes under the look  @param clip in the tubes' world space
[[nodiscard]] std::vector<glm::dvec3> visibleExtent(const Tubes& tubes, const ExtinctionGrid& visible,
                                                    const ClipParams& clip);

} // namespace vdblic
