#pragma once

#include "vdblic/field/bricks.h"
#include "vdblic/field/domain.h"
#include "vdblic/field/field_domain.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/field/slabs.h"
#include "vdblic/field/vector.h"
#include "vdblic/field/velocity_level.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <memory>
#include <optional>

namespace vdblic {

/// The largest magnitude of an active value, along each axis. Computed in parallel.
[[nodiscard]] Float4 largestMagnitude(const openvdb::Vec3STree& values);

/// An upper bound of a velocity's magnitude, along each axis [voxels per step].
/// @param magnitude largestMagnitude() of the stored values  @param toStep stored values → voxels per step
[[nodiscard]] Float4 largestVelocity(Float4 magnitude, const openvdb::Mat3d& toStep);

/// The velocity over one time step, in texture voxels per step, trilinear in space and linear in time between two
/// frames. Positions are in the index space of the texture, which may be finer than the velocity's; bricks hold the
/// velocity's own voxels. With cubic interpolation bricks hold the texture's voxels, and the velocity is trilinear
/// between them.
///
/// A voxel that has a velocity in only one of the frames keeps it for the whole step, the moment of the other frame
/// excluded. Any number of threads may sample, and none while leaves are filled or released.
class VelocityField {
  public:
    /// Begin a step; no leaf can be sampled yet.
    /// @param start, end the frames at the step's two ends, in voxels of the velocity per step; their trees outlive
    ///                   every fill()
    void prepare(FieldDomain domain, const VelocityLevel& start, const VelocityLevel& end);

    /// Fill leaves of the sampled velocity's domain. They can be sampled then from half a voxel before their first
    /// voxels' centres to the centres of the voxels after their last.
    void fill(Slabs::Leaves leaves);
    /// Free the memory of filled leaves; they cannot be sampled any longer.
    void release(Slabs::Leaves leaves) { mBricks.release(leaves); }

    /// prepare() and fill() everything.
    void build(FieldDomain domain, const VelocityLevel& start, const VelocityLevel& end);

    /// The window in which positions in and around a leaf of the texture's domain are expected.
    /// @param origin of the leaf
    [[nodiscard]] Bricks::Window window(const openvdb::Coord& origin) const
    {
        return mBricks.window(mSampled.refinement.coarse(origin));
    }

    /// @param position index space, voxel centres at integers; the fourth lane must be 0
    /// @param time     fraction of the step, 0 to 1
    /// @param outside  returned where the field has no value
    [[nodiscard]] VDBLIC_INLINE Float4 sample(Float4 position, float time, Float4 outside) const
    {
        const Bricks::Cell cell = mBricks.locate(position * mScale + mShift);
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

    /// Sample eight positions at once.
    /// @param window of window(), around where they are expected; elsewhere sampling is slower
    /// @param lanes  those to sample; the others' results have no meaning
    [[nodiscard]] VDBLIC_INLINE Vector8 sample(const Bricks::Window& window, const Vector8& position, Float8 time,
                                               const Vector8& outside, unsigned lanes) const
    {
        Float8 rows[8];
        const Vector8 coarse = {position.x * mScale[0] + mShift[0], position.y * mScale[1] + mShift[1],
                                position.z * mScale[2] + mShift[2]};
        mBricks.interpolate(window, coarse, lanes, rows);
        transpose(rows, rows);
        const auto between = [&](int number) { return rows[number] + (rows[number + 4] - rows[number]) * time; };
        const Float8 coverage = between(3);
        const Vector8 velocity = {between(0) / coverage, between(1) / coverage, between(2) / coverage};
        return select(coverage > 0, velocity, outside);
    }

    /// The frames at the step's start and end, in texture voxels per step.
    [[nodiscard]] const VelocityLevel& start() const { return *mStart; }
    [[nodiscard]] const VelocityLevel& end() const { return *mEnd; }

    /// An upper bound of the velocity's magnitude anywhere, along each axis [voxels per step].
    [[nodiscard]] Float4 largest() const { return mLargest; }

    /// Of the texture.
    [[nodiscard]] const Domain& domain() const { return *mDomain.texture; }
    [[nodiscard]] const FieldDomain& fieldDomain() const { return mDomain; }
    /// The texture's domain, and that of the bricks.
    [[nodiscard]] const FieldDomain& sampledDomain() const { return mSampled; }

  private:
    FieldDomain mDomain, mSampled;
    Float4 mScale{}, mShift{}; // from the texture's index space to the bricks'
    Bricks mBricks;
    std::optional<VelocityLevel> mStart, mEnd; // in voxels of the texture per step
    Float4 mLargest{};
};

} // namespace vdblic
