#pragma once

#include "vdblic/camera/camera.h"
#include "vdblic/run/sequence_info.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace vdblic {

/// The pixels that a voxel's two longer edges span on average, in the middle of the first picture.
/// @param stretch factors on the world's axes  @param size of the picture [pixels]
/// @param isGlobe whether the camera shows a ball, rather than a box
[[nodiscard]] double pixelsPerVoxel(const GridInfo& grid, const glm::dvec3& stretch, const glm::ivec2& size,
                                    ViewSide view, bool isGlobe);

} // namespace vdblic
