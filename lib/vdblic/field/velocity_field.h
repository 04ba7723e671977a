#pragma once

#include "vdblic/field/bricks.h"
#include "vdblic/field/domain.h"
#include "vdblic/field/frame_domain.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/field/slabs.h"
#include "vdblic/field/units.h"
#include "vdblic/field/vector.h"
#include "vdblic/field/velocities.h"

#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>

namespace vdblic {

/// The largest magnitude of an active value, along each axis. Computed in parallel.
[[nodiscard]] StoredSpeeds largestSpeeds(const openvdb::Vec3STree& values);

/// Upper bounds of a velocity's magnitude along the axes of a space, by its speeds along the stored axes.
template<Space kSpace, Per kTime>
[[nodiscard]] Speeds<kSpace, kTime> largestSpeeds(const StoredSpeeds& stored, const FromStored<kSpace, kTime>& unit)
{
    Speeds<kSpace, kTime> most;
    for (int to = 0; to < 3; ++to) {
        for (int from = 0; from < 3; ++from)
            most.along[std::size_t(to)] += float(std::abs(unit.matrix(to, from))) * stored[std::size_t(from)];
    }
    return most;
}

/// The larger of two speeds along each axis.
template<Space kSpace, Per kTime>
[[nodiscard]] Speeds<kSpace, kTime> larger(const Speeds<kSpace, kTime>& a, const Speeds<kSpace, kTime>& b)
{
    return {{std::max(a[0], b[0]), std::max(a[1], b[1]), std::max(a[2], b[2])}};
}

/// The velocity over one time step, in texture voxels per step: trilinear in space, linear in time between two frames.
/// Positions are in the texture's index space, which may be finer than the velocity's. Bricks hold the velocity's own
/// voxels, or with cubic interpolation the texture's, trilinear in between.
///
/// A voxel with a velocity in only one frame keeps it for the whole step, but for the moment of the other frame. Any
/// number of threads may sample, but not while leaves are filled or released.
class VelocityField {
  public:
    /// Begin a step; no leaf can be sampled yet.
    /// @param start, end at the step's two ends; their trees outlive every fill()
    void prepare(FrameDomain domain, const Velocities<Space::kVelocity, Per::kStep>& start,
                 const Velocities<Space::kVelocity, Per::kStep>& end);

    /// Fill leaves of the sampled velocity's domain. They can then be sampled from half a voxel below their first
    /// voxels' centres to the centres of the voxels after their last.
    void fill(Slabs::Leaves leaves);
    /// Free filled leaves, which can then no longer be sampled.
    void release(Slabs::Leaves leaves) { mBricks.release(leaves); }

    /// prepare() and fill() all leaves.
    void build(FrameDomain domain, const Velocities<Space::kVelocity, Per::kStep>& start,
               const Velocities<Space::kVelocity, Per::kStep>& end);

    /// The window in which positions in and around a leaf of the texture's domain are expected.
    /// @param origin of the leaf
    [[nodiscard]] Bricks::Window window(const openvdb::Coord& origin) const
    {
        return mBricks.window(mSampled.refinement.coarse({origin}).at);
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
    /// @param window of window(), where the positions are expected; others are slower
    /// @param lanes  lanes to sample; the results of others have no meaning
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

    /// The velocities at the step's start and end.
    [[nodiscard]] const Velocities<Space::kTexture, Per::kStep>& start() const { return *mStart; }
    [[nodiscard]] const Velocities<Space::kTexture, Per::kStep>& end() const { return *mEnd; }

    /// An upper bound of the velocity's magnitude anywhere.
    [[nodiscard]] const Speeds<Space::kTexture, Per::kStep>& largest() const { return mLargest; }

    /// The texture's domain.
    [[nodiscard]] const Domain& domain() const { return *mDomain.texture; }
    [[nodiscard]] const FrameDomain& frameDomain() const { return mDomain; }
    /// The domains of texture and bricks.
    [[nodiscard]] const FrameDomain& sampledDomain() const { return mSampled; }

  private:
    FrameDomain mDomain, mSampled;
    Float4 mScale{}, mShift{}; // from the texture's index space to the bricks'
    Bricks mBricks;
    std::optional<Velocities<Space::kTexture, Per::kStep>> mStart, mEnd;
    Speeds<Space::kTexture, Per::kStep> mLargest;
};

} // namespace vdblic
