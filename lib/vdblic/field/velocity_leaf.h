#pragma once

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"
#include "vdblic/field/velocities.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>

namespace vdblic {

/// The velocities of a frame in one leaf of index space: of a leaf node, a part of a tile, or none.
class VelocityLeaf {
  public:
    /// No velocities.
    VelocityLeaf() = default;
    /// @param velocities the stored ones must outlive this  @param origin of the leaf
    template<Space kSpace, Per kTime>
    VelocityLeaf(const Velocities<kSpace, kTime>& velocities, const openvdb::Coord& origin)
    {
        const openvdb::Coord at = velocities.period.wrapped(origin);
        mLeaf = velocities.stored.probeConstLeaf(at);
        for (int to = 0; to < 3; ++to) {
            for (int from = 0; from < 3; ++from)
                mUnit[from][to] = float(velocities.unit.matrix(to, from));
        }
        if (mLeaf) {
            mStored = mLeaf->buffer().data();
        } else {
            mIsActive = velocities.stored.probeValue(at, mConstant);
        }
    }

    /// A row of voxels along z; 0 where there is no velocity.
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
            return stored.x * mUnit[0][i] + stored.y * mUnit[1][i] + stored.z * mUnit[2][i];
        };
        return {select(active, {component(0), component(1), component(2)}, Vector8{}), active};
    }

    /// The velocity of a row's first voxel and 1; zeros if there is none.
    [[nodiscard]] VDBLIC_INLINE Float4 first(int number) const
    {
        const auto offset = openvdb::Index(number * LeafVoxel::kDim);
        if (mLeaf ? !mLeaf->isValueOn(offset) : !mIsActive) return Float4{};
        const openvdb::Vec3f& stored = mLeaf ? mStored[offset] : mConstant;
        Float4 velocity = mUnit[0] * stored[0] + mUnit[1] * stored[1] + mUnit[2] * stored[2];
        velocity[3] = 1;
        return velocity;
    }

  private:
    Float4 mUnit[3] = {}; // FromStored::matrix, by columns
    const openvdb::Vec3STree::LeafNodeType* mLeaf = nullptr;
    const openvdb::Vec3f* mStored = nullptr; // the leaf's
    openvdb::Vec3f mConstant{0};             // of a tile
    bool mIsActive = false;
};

} // namespace vdblic
