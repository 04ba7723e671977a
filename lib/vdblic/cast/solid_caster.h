#pragma once

#include "vdblic/camera/clipping.h"
#include "vdblic/cast/surface_picture.h"

#include <glm/vec3.hpp>

#include <span>

namespace vdblic {

class Camera;
class LightGrid;
class TextureVolume;
struct Look;
struct Solid;

/// Find the first surface of a solid along each pixel's ray, and light it by the look's lights. Where a cut opens the
/// solid its face is a surface.
/// @param color linear light  @param cuts in world space  @param light shadows of the volume, or null
/// @param ray   index among each pixel's rays
[[nodiscard]] SurfacePicture castSolid(const Solid& solid, const glm::vec3& color, std::span<const ClipPlane> cuts,
                                       const TextureVolume& volume, const Look& look, const Camera& camera,
                                       const LightGrid* light, int ray);

} // namespace vdblic
