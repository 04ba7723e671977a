#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <vector>

namespace vdblic {

/// A box of voxels.
struct InclusiveBox {
    std::array<int, 3> low, high; ///< inclusive

    bool operator==(const InclusiveBox&) const = default;
    /// Its corners, faces of voxels included. @param indexToWorld of any affine transform
    [[nodiscard]] std::array<glm::dvec3, 8> corners(const glm::dmat4& indexToWorld) const;
};

/// The boxes that reach farthest in some of 128 directions, each once, sorted; their order does not matter. So the
/// outermost boxes of all parts include the whole's.
/// @param extent of what holds the boxes, above 0; directions are even where it is a cube
[[nodiscard]] std::vector<InclusiveBox> outermost(const std::vector<InclusiveBox>& boxes, const glm::dvec3& extent);

} // namespace vdblic
