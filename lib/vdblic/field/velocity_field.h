#pragma once

#include "vdblic/field/bricks.h"

namespace vdblic {

/// One frame's velocities and what turns them into voxels per step.
struct VelocityLevel {
    const openvdb::Vec3STree& velocities; ///< on voxel centres, in any unit
    openvdb::Mat3d toStep;                ///< stored value → voxels per step, in index space
};

/// The velocity over one time step, in voxels per step, trilinear in space and linear in time between two frames.
///
/// A voxel that has a velocity in only one of the frames keeps it for the whole step, up to the very moment of the
/// frame in which it has none. Any number of threads may sample.
class VelocityField {
  public:
    /// @param domain the leaves to sample in
    /// @param start, end the frames at the step's two ends
    void build(std::shared_ptr<const Domain> domain, const VelocityLevel& start, const VelocityLevel& end);

    /// @param position index space, voxel centres at integers; the fourth lane must be 0
    /// @param time     fraction of the step, 0 to 1
    /// @param outside  returned where the field has no value
    [[nodiscard]] VDBLIC_INLINE Float4 sample(Float4 position, float time, Float4 outside) const
    {
        const Bricks::Cell cell = mBricks.locate(position);
        if (__builtin_expect(!cell.corner, 0)) return outside;
        const Float8 both = Bricks::interpolate(cell);
        const Float4 start = __builtin_shufflevector(both, both, 0, 1, 2, 3);
        const Float4 end = __builtin_shufflevector(both, both, 4, 5, 6, 7);
        const Float4 sum = start + (end - start) * time;
        const float coverage = sum[3];
        if (__builtin_expect(!(coverage > 0), 0)) return outside;
        Float4 velocity = sum / coverage;
        velocity[3] = 0;
        return velocity;
    }

    [[nodiscard]] const Domain& domain() const { return mBricks.domain(); }

  private:
    Bricks mBricks;
};

} // namespace vdblic
