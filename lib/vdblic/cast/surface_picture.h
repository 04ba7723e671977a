#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <vector>

namespace vdblic {

/// The surface behind each pixel's centre, without the volume.
struct SurfacePicture {
    std::vector<float> depths;      ///< along the view axis from the eye's plane [world]; infinite where there is none
    std::vector<glm::vec4> colors;  ///< linear light, lit; premultiplied by alpha
    std::vector<glm::vec3> normals; ///< world space, of length 1
};

} // namespace vdblic
