#pragma once

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/refinement.h"
#include "vdblic/field/vector.h"
#include "vdblic/field/velocities.h"
#include "vdblic/field/velocity_leaf.h"

#include <openvdb/openvdb.h>

#include <array>
#include <cstddef>

namespace vdblic {

/// Velocities at the voxel centres of a texture leaf, in texture voxels per step; 0 without a velocity.
///
/// Without refinement, the stored values. Else trilinear between the valid corners of the velocity's cell, as in
/// VelocityField.
class LeafVelocities {
  public:
    /// @param origin of the texture's leaf
    LeafVelocities(const Velocities<Space::kTexture, Per::kStep>& velocities, const Refinement& refinement,
                   const openvdb::Coord& origin);

    /// The velocities of a row of voxels along z.
    [[nodiscard]] VDBLIC_INLINE Vector8 row(int row) const
    {
        return mIsRefined ? between(row) : mStored.row(row).velocities;
    }

  private:
    static constexpr int kMostCorners = LeafVoxel::kDim + 1; // of cells along an axis: one voxel a cell

    /// The cell around a texture voxel's centre along one axis: index of its first corner, and fraction of the cell.
    struct Cell {
        int first = 0;
        float fraction = 0;
    };

    [[nodiscard]] VDBLIC_INLINE Vector8 between(int row) const
    {
        const LeafVoxel voxel = LeafVoxel::ofRow(row);
        const Cell x = mCells[0][std::size_t(voxel.x)];
        const auto& before = mLines[std::size_t(voxel.y)][std::size_t(x.first)];
        const auto& after = mLines[std::size_t(voxel.y)][std::size_t(x.first) + 1];
        std::array<Float4, kMostCorners> line; // records at one x and y
        for (int k = 0; k < mCorners[2]; ++k)
            line[std::size_t(k)] = mix(before[std::size_t(k)], after[std::size_t(k)], x.fraction);
        Float4 rows[LeafVoxel::kDim];
        for (int z = 0; z < LeafVoxel::kDim; ++z) {
            const Cell cell = mCells[2][std::size_t(z)];
            rows[z] = mix(line[std::size_t(cell.first)], line[std::size_t(cell.first) + 1], cell.fraction);
        }
        Float8 columns[4];
        transpose(rows, columns);
        const Int8 covered = columns[3] > 0;
        const Float8 coverage = covered ? columns[3] : broadcast8(1);
        const Vector8 mean = {columns[0] / coverage, columns[1] / coverage, columns[2] / coverage};
        return toStep(select(covered, mean, Vector8{}));
    }

    [[nodiscard]] VDBLIC_INLINE static Float4 mix(Float4 a, Float4 b, float t) { return a * (1 - t) + b * t; }

    [[nodiscard]] VDBLIC_INLINE Vector8 toStep(const Vector8& values) const
    {
        const auto component = [&](int i) {
            return values.x * mToStep(i, 0) + values.y * mToStep(i, 1) + values.z * mToStep(i, 2);
        };
        return {component(0), component(1), component(2)};
    }

    openvdb::Mat3s mToStep;
    bool mIsRefined;
    VelocityLeaf mStored; // without refinement
    // With refinement: values times coverage, and as fourth number the coverage.
    using Line = std::array<Float4, kMostCorners>;
    std::array<int, 3> mCorners{}; // along each axis
    std::array<std::array<Cell, LeafVoxel::kDim>, 3> mCells{};
    std::array<std::array<Line, kMostCorners>, LeafVoxel::kDim> mLines; // along z, by texture y and corner x
};

} // namespace vdblic
