#pragma once

#include "vdblic/field/bricks.h"

#include <openvdb/openvdb.h>

#include <memory>

namespace vdblic {

/// Standard deviation of a texture's voxels, and the share of them that eight bits would show as black or white.
struct Contrast {
    double deviation = 0, saturated = 0;
};

/// A texture to sample, as it is and smoothed with the 3³ binomial filter (weights 1 2 1 along each axis).
///
/// The filter takes the voxels that have a value, with their weights brought up to a sum of 1. Immutable; any number
/// of threads may sample.
class SmoothedTexture {
  public:
    /// Builds in parallel; the result does not depend on the number of threads.
    /// @param texture active voxels and tiles have a value, others have none
    explicit SmoothedTexture(const openvdb::FloatTree& texture);

    struct Sample {
        float raw, smoothed;
        bool inside; ///< all eight voxels around have a value; without that the numbers mean nothing
    };

    /// Trilinear interpolation. @param position index space, voxel centres at integers
    [[nodiscard]] VDBLIC_INLINE Sample sample(Float4 position) const
    {
        // Bricks go on below the domain with its first values; here that is outside.
        if (domain().findLeaf(floorToInt(position)) < 0) return {0, 0, false};
        const Bricks::Cell cell = mBricks.locate(position);
        const Float8 values = Bricks::interpolate(cell);
        constexpr float kFull = 1 - 1e-4f; // but for rounding
        return {values[kRaw], values[kSmoothed], values[kCoverage] > kFull};
    }

    [[nodiscard]] const Domain& domain() const { return mBricks.domain(); }
    /// Over every voxel. Not-a-number if there are none, or if one is not finite.
    [[nodiscard]] const Contrast& rawContrast() const { return mRawContrast; }
    [[nodiscard]] const Contrast& smoothedContrast() const { return mSmoothedContrast; }

  private:
    enum { kRaw, kSmoothed, kCoverage };

    Bricks mBricks;
    Contrast mRawContrast, mSmoothedContrast;
};

} // namespace vdblic
