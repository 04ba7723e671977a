#pragma once

#include "vdblic/field/refinement.h"
#include "vdblic/field/units.h"
#include "vdblic/field/vector.h"

#include <cstddef>

namespace vdblic {

/// A position in a space. In index spaces the fourth lane is 0.
template<Space kSpace>
struct Position {
    Float4 at{};
};

/// Between the index spaces of a texture and of its velocity. Immutable; any number of threads may read.
class IndexSpaces {
  public:
    explicit IndexSpaces(const Refinement& refinement)
    {
        for (int axis = 0; axis < 3; ++axis) {
            mScale[axis] = refinement.scale(axis);
            mShift[axis] = refinement.shift(axis);
            mFactor[axis] = float(refinement.factors[std::size_t(axis)]);
        }
    }
    [[nodiscard]] Position<Space::kVelocity> velocity(Position<Space::kTexture> position) const
    {
        return {position.at * mScale + mShift};
    }
    [[nodiscard]] Position<Space::kTexture> texture(Position<Space::kVelocity> position) const
    {
        return {(position.at - mShift) * mFactor};
    }
    /// Voxels of the velocity in a voxel of the texture along each axis, and the other way round; 1 in the fourth lane.
    [[nodiscard]] Float4 scale() const { return mScale; }
    [[nodiscard]] Float4 factor() const { return mFactor; }

  private:
    Float4 mScale{1, 1, 1, 1}, mShift{}, mFactor{1, 1, 1, 1};
};

} // namespace vdblic
