#pragma once

#include <glm/mat4x4.hpp>
#include <openvdb/math/Transform.h>

#include <string>

namespace vdblic {

/// The matrix of a grid's transform, index space → world space.
/// @param grid names the grid in messages
/// @throws InputError if the transform is not affine, or flattens space
[[nodiscard]] glm::dmat4 affineMatrix(const openvdb::math::Transform& transform, const std::string& grid);

} // namespace vdblic
