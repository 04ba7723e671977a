#pragma once

#include <glm/vec3.hpp>

#include <vector>

namespace vdblic {

class Camera;
class LightGrid;
class TextureVolume;
struct Look;
struct Solid;

/// What is seen of a solid through each pixel's centre, the volume taken away.
struct SolidPicture {
    std::vector<float> depths;     ///< along the view axis from the eye's plane [world]; infinite where nothing is seen
    std::vector<glm::vec3> colors; ///< linear light, lit
    std::vector<glm::vec3> normals; ///< world space, of length 1
};

/// Find the first surface of a solid along each pixel's ray, and light it by the look's lights.
/// @param color linear light  @param light shadows of the volume, or null
[[nodiscard]] SolidPicture castSolid(const Solid& solid, const glm::vec3& color, const TextureVolume& volume,
                                     const Look& look, const Camera& camera, const LightGrid* light);

} // namespace vdblic
