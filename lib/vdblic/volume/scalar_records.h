#pragma once

#include "vdblic/field/vector.h"
#include "vdblic/volume/coarse_scalar.h"
#include "vdblic/volume/record_sampling.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstring>
#include <memory>
#include <optional>

namespace vdblic {

/// A scalar's values around each leaf of a texture, on the texture's voxels or on coarser ones. The values of a leaf
/// are set once; then any number of threads may read.
class ScalarRecords {
  public:
    ScalarRecords() = default;
    /// @param coarse the scalar if it is on coarser voxels; must outlive the calls of copyCoarse()
    ScalarRecords(std::size_t leaves, const std::optional<CoarseScalar>& coarse);

    [[nodiscard]] bool isCoarse() const { return mIsCoarse; }
    /// Set the values of a leaf of a scalar on coarser voxels. @return their range; nothing if no voxel is active
    std::optional<std::array<float, 2>> copyCoarse(const CoarseScalar& coarse, std::size_t leaf,
                                                   const openvdb::Coord& origin);
    /// The values of a leaf of a scalar on the texture's voxels, as ScalarLeaf has them.
    [[nodiscard]] float* values(std::size_t leaf) { return mValues.get() + leaf * mSize; }
    [[nodiscard]] const float* values(std::size_t leaf) const { return mValues.get() + leaf * mSize; }

    /// Trilinear interpolation at eight samples.
    /// @param leaf     numbers of the leaves
    /// @param position relative to their origins, −1 to 8
    [[nodiscard]] VDBLIC_INLINE Float8 at(Unsigned8 leaf, const Float8* position) const
    {
        const Unsigned8 base = leaf * unsigned(mSize);
        Float8 place[3] = {position[0] + 1, position[1] + 1, position[2] + 1};
        if (mIsCoarse) toCoarse(base, position, place);
        const Cells cells(place);
        const Unsigned8 low =
            base + unsigned(mFirst) + Unsigned8((cells.low[0] * mDim[1] + cells.low[1]) * mDim[2] + cells.low[2]);
        return interpolate(mValues.get(), low, mDim[2], mDim[1] * mDim[2], cells.fraction);
    }

    /// The values at a row of a leaf's voxels along z.
    [[nodiscard]] VDBLIC_INLINE Float8 row(std::size_t leaf, int x, int y) const
    {
        if (mIsCoarse) {
            const Float8 position[] = {broadcast8(float(x)), broadcast8(float(y)), Float8{0, 1, 2, 3, 4, 5, 6, 7}};
            return at(Unsigned8{} + unsigned(leaf), position);
        }
        Float8 row;
        std::memcpy(&row, values(leaf) + ScalarLeaf::index(x, y, 0), sizeof row);
        return row;
    }

    [[nodiscard]] std::size_t bytesPerLeaf() const { return mSize * sizeof(float); }

  private:
    static constexpr std::size_t kOffsets = 4; // numbers before a coarse leaf's values; the last one is not used

    VDBLIC_INLINE void toCoarse(Unsigned8 base, const Float8* position, Float8* place) const
    {
        std::uint32_t at[kLanes];
        storeLanes(base, at);
        for (int axis = 0; axis < 3; ++axis) {
            Float8 offset{};
            for (int lane = 0; lane < kLanes; ++lane)
                offset[lane] = mValues[at[lane] + unsigned(axis)];
            place[axis] = position[axis] * mScale[axis] + offset;
        }
    }

    bool mIsCoarse = false;
    int mDim[3] = {ScalarLeaf::kDim, ScalarLeaf::kDim, ScalarLeaf::kDim};
    std::size_t mSize = ScalarLeaf::kSize, mFirst = 0; // numbers of a leaf, and before its values
    float mScale[3] = {1, 1, 1};
    std::unique_ptr<float[]> mValues;
};

} // namespace vdblic
