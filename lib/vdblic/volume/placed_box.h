#pragma once

#include "vdblic/camera/camera.h"

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <cmath>

namespace vdblic {

/// A box in an index space, and where that space lies in the world of a picture.
class PlacedBox {
  public:
    explicit PlacedBox(const glm::dmat4& indexToWorld)
        : mIndexToWorld(indexToWorld), mWorldToIndex(glm::inverse(indexToWorld))
    {
    }

    [[nodiscard]] const glm::dvec3& low() const { return mLow; } ///< index space, as high()
    [[nodiscard]] const glm::dvec3& high() const { return mHigh; }
    /// The corners in world space.
    [[nodiscard]] Corners corners() const
    {
        Corners result;
        for (unsigned i = 0; i < 8; ++i) {
            const glm::dvec3 corner(i & 1 ? mHigh.x : mLow.x, i & 2 ? mHigh.y : mLow.y, i & 4 ? mHigh.z : mLow.z);
            result[i] = glm::dvec3(mIndexToWorld * glm::dvec4(corner, 1));
        }
        return result;
    }
    [[nodiscard]] const glm::dmat4& indexToWorld() const { return mIndexToWorld; }
    [[nodiscard]] const glm::dmat4& worldToIndex() const { return mWorldToIndex; }
    /// The cube root of a voxel's volume [world].
    [[nodiscard]] double voxelSize() const { return std::cbrt(std::abs(glm::determinant(glm::dmat3(mIndexToWorld)))); }

  protected:
    glm::dvec3 mLow{0}, mHigh{0};

  private:
    glm::dmat4 mIndexToWorld, mWorldToIndex;
};

} // namespace vdblic
