#pragma once

#include "vdblic/field/bricks.h"

#include <openvdb/openvdb.h>

#include <array>
#include <cstddef>
#include <memory>

namespace vdblic {

/// Standard deviation of a texture's voxel values, and the share of voxels that eight bits would show as black or
/// white.
struct Contrast {
    double deviation = 0, saturated = 0;
};

/// A texture to sample, as it is and smoothed with the 3³ binomial filter (weights 1 2 1 along each axis).
///
/// The filter weights the neighbours that have a value, and normalises their weights to a sum of 1. Immutable; any
/// number of threads may sample.
class SmoothedTexture {
  public:
    /// Builds in parallel; the result does not depend on the number of threads.
    /// @param texture active voxels and tiles have a value, all others have none
    explicit SmoothedTexture(const openvdb::FloatTree& texture);

    struct Sample {
        float raw, smoothed;
        bool inside; ///< all eight voxels around have a value; the other members are valid only then
    };

    /// Trilinear interpolation. @param position index space, voxel centres at integers
    [[nodiscard]] VDBLIC_INLINE Sample sample(Float4 position) const
    {
        // Below the domain, bricks repeat its first values; such a position is outside.
        if (domain().findLeaf(floorToInt(position)) < 0) return {0, 0, false};
        const Values::Cell cell = mBricks.locate(position);
        const Float4 values = Values::interpolate(cell);
        constexpr float kFull = 1 - 1e-4f; // 1 less rounding
        return {values[kRaw], values[kSmoothed], values[kCoverage] > kFull};
    }

    /// Copy the raw values of voxels along z. @param first voxel @return whether all voxels have a value
    template<std::size_t kCount>
    [[nodiscard]] VDBLIC_INLINE bool copyRow(Int4 first, std::array<float, kCount>& values) const
    {
        int leaf = domain().findLeaf(first);
        for (int i = 0; i < int(kCount); ++i) {
            const Int4 voxel = first + Int4{0, 0, i, 0};
            const int z = LeafVoxel::local(voxel[2]);
            if (i > 0 && z == 0) leaf = domain().findLeaf(voxel);
            if (leaf < 0) return false;
            const auto* record =
                mBricks.record(leaf, Values::index(LeafVoxel::local(voxel[0]), LeafVoxel::local(voxel[1]), z));
            if (record->values[kCoverage] == 0) return false;
            values[std::size_t(i)] = record->values[kRaw];
        }
        return true;
    }

    [[nodiscard]] const Domain& domain() const { return mBricks.domain(); }
    [[nodiscard]] const std::shared_ptr<const Domain>& sharedDomain() const { return mBricks.sharedDomain(); }
    /// Over all voxels. Not-a-number if there are none or if a value is not finite.
    [[nodiscard]] const Contrast& rawContrast() const { return mRawContrast; }
    [[nodiscard]] const Contrast& smoothedContrast() const { return mSmoothedContrast; }

  private:
    using Values = BricksOf<4>;
    enum { kRaw, kSmoothed, kCoverage };

    Values mBricks;
    Contrast mRawContrast, mSmoothedContrast;
};

} // namespace vdblic
