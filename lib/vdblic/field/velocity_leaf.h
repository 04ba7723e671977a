#pragma once

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"
#include "vdblic/field/velocity_level.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>

namespace vdblic {

/// The velocities of a level in one leaf of index space, be they a leaf, a part of a tile or none.
class VelocityLeaf {
  public:
    /// Without velocities.
    VelocityLeaf() = default;
    /// @param level its velocities must outlive this  @param origin of the leaf
    VelocityLeaf(const VelocityLevel& level, const openvdb::Coord& origin)
        : mLeaf(level.velocities.probeConstLeaf(origin))
    {
        for (int to = 0; to < 3; ++to) {
            for (int from = 0; from < 3; ++from)
                mToStep[from][to] = float(level.toStep(to, from));
        }
        if (mLeaf) {
            mStored = mLeaf->buffer().data();
        } else {
            mIsActive = level.velocities.probeValue(origin, mConstant);
        }
    }

    /// A row of voxels along z, in voxels per step; 0 where there is no velocity.
    struct Row {
        Vector8 velocities;
        Int8 active;
    };
    [[nodiscard]] VDBLIC_INLINE Row row(int number) const
    {
        const Int8 active = maskOf(mLeaf       ? mLeaf->getValueMask().getWord<std::uint8_t>(openvdb::Index(number))
                                   : mIsActive ? 0xff
                                               : 0);
        const Vector8 stored =
            mLeaf ? loadVectors(mStored[number * std::ptrdiff_t(LeafVoxel::kDim)].asPointer())
                  : Vector8{broadcast8(mConstant[0]), broadcast8(mConstant[1]), broadcast8(mConstant[2])};
        const auto component = [&](int i) {
            return stored.x * mToStep[0][i] + stored.y * mToStep[1][i] + stored.z * mToStep[2][i];
        };
        return {select(active, {component(0), component(1), component(2)}, Vector8{}), active};
    }

    /// The velocity of a row's first voxel and 1; zeros if there is none.
    [[nodiscard]] VDBLIC_INLINE Float4 first(int number) const
    {
        const auto offset = openvdb::Index(number * LeafVoxel::kDim);
        if (mLeaf ? !mLeaf->isValueOn(offset) : !mIsActive) return Float4{};
        const openvdb::Vec3f& stored = mLeaf ? mStored[offset] : mConstant;
        Float4 velocity = mToStep[0] * stored[0] + mToStep[1] * stored[1] + mToStep[2] * stored[2];
        velocity[3] = 1;
        return velocity;
    }

  private:
    Float4 mToStep[3] = {}; // stored values → voxels per step, by columns
    const openvdb::Vec3STree::LeafNodeType* mLeaf = nullptr;
    const openvdb::Vec3f* mStored = nullptr; // the leaf's
    openvdb::Vec3f mConstant{0};             // without a leaf
    bool mIsActive = false;
};

} // namespace vdblic
