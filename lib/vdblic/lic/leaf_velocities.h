#pragma once

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/refinement.h"
#include "vdblic/field/vector.h"
#include "vdblic/field/velocity_field.h"

#include <openvdb/openvdb.h>

#include <array>
#include <cstddef>

namespace vdblic {

/// Velocities at the voxel centres of one leaf of a texture, in its voxels per step; 0 where there is none.
///
/// Without refinement they are the stored values; else they are interpolated trilinearly between those corners of the
/// velocity's cell that have a value, as VelocityField does.
class LeafVelocities {
  public:
    /// @param level  in texture voxels per step  @param origin of the texture's leaf
    LeafVelocities(const VelocityLevel& level, const Refinement& refinement, const openvdb::Coord& origin);

    /// The velocities of a row of voxels along z.
    [[nodiscard]] VDBLIC_INLINE Vector8 row(int row) const { return mIsRefined ? between(row) : stored(row); }

  private:
    static constexpr int kMostCorners = LeafVoxel::kDim + 1; // of cells along an axis: one voxel a cell

    /// The cell that a texture voxel's centre lies in, along one axis: its first corner's index in mRecords, and the
    /// fraction of the cell.
    struct Cell {
        int first = 0;
        float fraction = 0;
    };

    [[nodiscard]] VDBLIC_INLINE Vector8 stored(int row) const
    {
        Vector8 values{};
        for (int z = 0; z < LeafVoxel::kDim; ++z) {
            const auto offset = openvdb::Index(LeafVoxel::kDim * row + z);
            const openvdb::Vec3f value = !mLeaf                     ? mConstant
                                         : mLeaf->isValueOn(offset) ? mLeaf->buffer().data()[offset]
                                                                    : openvdb::Vec3f(0);
            values.setLane(z, Float4{value[0], value[1], value[2], 0});
        }
        return toStep(values);
    }

    [[nodiscard]] VDBLIC_INLINE Vector8 between(int row) const
    {
        const LeafVoxel voxel = LeafVoxel::ofRow(row);
        const Cell x = mCells[0][std::size_t(voxel.x)], y = mCells[1][std::size_t(voxel.y)];
        std::array<Float4, kMostCorners> line; // of records, at this x and y
        for (std::size_t k = 0; k < line.size(); ++k) {
            const auto mix = [](Float4 a, Float4 b, float t) { return a * (1 - t) + b * t; };
            const auto at = [&](std::size_t i, std::size_t j) {
                return mRecords[std::size_t(x.first) + i][std::size_t(y.first) + j][k];
            };
            line[k] = mix(mix(at(0, 0), at(0, 1), y.fraction), mix(at(1, 0), at(1, 1), y.fraction), x.fraction);
        }
        Vector8 values{};
        for (int z = 0; z < LeafVoxel::kDim; ++z) {
            const Cell cell = mCells[2][std::size_t(z)];
            const auto k = std::size_t(cell.first);
            const Float4 sum = line[k] * (1 - cell.fraction) + line[k + 1] * cell.fraction;
            values.setLane(z, sum[3] > 0 ? sum / sum[3] : Float4{});
        }
        return toStep(values);
    }

    [[nodiscard]] VDBLIC_INLINE Vector8 toStep(const Vector8& values) const
    {
        const auto component = [&](int i) {
            return values.x * mToStep(i, 0) + values.y * mToStep(i, 1) + values.z * mToStep(i, 2);
        };
        return {component(0), component(1), component(2)};
    }

    openvdb::Mat3s mToStep;
    bool mIsRefined;
    // Not refined:
    const openvdb::Vec3STree::LeafNodeType* mLeaf = nullptr;
    openvdb::Vec3f mConstant{};
    // Refined: stored values premultiplied by their coverage, which is the fourth number.
    std::array<std::array<Cell, LeafVoxel::kDim>, 3> mCells{};
    std::array<std::array<std::array<Float4, kMostCorners>, kMostCorners>, kMostCorners> mRecords;
};

} // namespace vdblic
