#pragma once

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/period.h"
#include "vdblic/field/vector.h"
#include "vdblic/noise/noise.h"
#include "vdblic/noise/noise_field.h"

#include <openvdb/openvdb.h>

#include <cstdint>
#include <cstring>

namespace vdblic {

/// IBFV's noise: low-pass filtered in space and time, and periodic in time.
///
/// Every second voxel along each axis blinks: white for half a period, black for the other half, with a phase from the
/// noise of that voxel. Values between are interpolated trilinearly: van Wijk, "Image based flow visualization",
/// SIGGRAPH 2002, section 3.3, with its square wave and a spacing of two voxels. The noise continues outside the
/// domain. A pure function of place and time.
class PeriodicNoise {
  public:
    static constexpr int kSpacing = 2; ///< between points of the noise [voxels]
    static constexpr int kPeriod = 8;  ///< [frames]
    static constexpr int kBrick = LeafVoxel::kDim + 1;

    /// The noise at one time. @param noise must outlive this  @param step number  @param substeps steps in a frame
    /// @param period of a periodic box, whose images have the same noise
    PeriodicNoise(const NoiseField& noise, std::uint64_t step, int substeps, const Period& period = {})
        : mNoise(&noise), mPeriod(period), mIsPeriodicInSpace(!period.isNone()),
          mOfStep(std::uint32_t((kNoiseMax + 1) / (kPeriod * substeps))), mTurn(std::uint32_t(step) * mOfStep)
    {
    }
    /// Go back by a step, also before the run's first one.
    VDBLIC_INLINE void goBack() { mTurn -= mOfStep; }

    /// The noise, 0 to 1, at a position in index space.
    [[nodiscard]] VDBLIC_INLINE float at(Float4 position) const
    {
        const Float4 points = position * (1.0f / kSpacing);
        const Int4 first = floorToInt(points);
        const Float4 part = points - __builtin_convertvector(first, Float4);
        std::int32_t corners[kLanes];
        const openvdb::Coord low(kSpacing * first[0], kSpacing * first[1], kSpacing * first[2]);
        if (mIsPeriodicInSpace) {
            for (int corner = 0; corner < kLanes; ++corner) {
                corners[corner] = mNoise->at(mPeriod.wrapped(
                    low.offsetBy(kSpacing * (corner >> 2), kSpacing * (corner >> 1 & 1), kSpacing * (corner & 1))));
            }
        } else {
            mNoise->atCorners(low, kSpacing, corners);
        }
        Int8 phases;
        std::memcpy(&phases, corners, sizeof phases);
        phases += int(mTurn);
        const float x = part[0], y = part[1], z = part[2];
        const Float4 face = Float4{1 - y, 1 - y, y, y} * Float4{1 - z, z, 1 - z, z};
        const Float4 white = wave(__builtin_shufflevector(phases, phases, 0, 1, 2, 3)) * (1 - x) +
                             wave(__builtin_shufflevector(phases, phases, 4, 5, 6, 7)) * x;
        const Float4 weighed = white * face;
        return (weighed[0] + weighed[1]) + (weighed[2] + weighed[3]);
    }

    /// The noise at the voxels of a leaf and the next ones in each positive direction.
    /// @param values kBrick³ numbers, x slowest
    void fill(const openvdb::Coord& origin, float* values) const;

  private:
    [[nodiscard]] VDBLIC_INLINE static Float4 wave(Int4 phases)
    {
        return (phases & kNoiseMax) <= kNoiseMax / 2 ? broadcast4(1) : Float4{};
    }
    /// The noise of a point, in multiples of the spacing.
    [[nodiscard]] float ofPoint(int x, int y, int z) const;

    const NoiseField* mNoise;
    Period mPeriod;
    bool mIsPeriodicInSpace;
    std::uint32_t mOfStep, mTurn; ///< 2⁻¹⁶ periods: per step, and since the first step
};

} // namespace vdblic
