#include "vdblic/lic/leaf_velocities.h"

#include <cmath>

namespace vdblic {

LeafVelocities::LeafVelocities(const Velocities<Space::kTexture, Per::kStep>& velocities, const Refinement& refinement,
                               const openvdb::Coord& origin)
    : mToStep(velocities.unit.matrix), mIsRefined(!refinement.isNone())
{
    if (!mIsRefined) {
        mStored = VelocityLeaf(velocities, origin);
        return;
    }
    openvdb::Coord first;
    for (int axis = 0; axis < 3; ++axis) {
        const auto position = [&](int voxel) {
            return float(origin[axis] + voxel) * refinement.scale(axis) + refinement.shift(axis);
        };
        first[axis] = int(std::floor(position(0)));
        for (int voxel = 0; voxel < LeafVoxel::kDim; ++voxel) {
            const float cell = std::floor(position(voxel));
            mCells[std::size_t(axis)][std::size_t(voxel)] = {int(cell) - first[axis], position(voxel) - cell};
        }
        mCorners[std::size_t(axis)] = mCells[std::size_t(axis)].back().first + 2;
    }
    const openvdb::tree::ValueAccessor<const openvdb::Vec3STree> values(velocities.stored);
    std::array<Line, kMostCorners> plane; // records at one x
    for (int x = 0; x < mCorners[0]; ++x) {
        for (int y = 0; y < mCorners[1]; ++y) {
            for (int z = 0; z < mCorners[2]; ++z) {
                openvdb::Vec3f value;
                const bool active = values.probeValue(velocities.period.wrapped(first.offsetBy(x, y, z)), value);
                plane[std::size_t(y)][std::size_t(z)] = active ? Float4{value[0], value[1], value[2], 1} : Float4{};
            }
        }
        for (std::size_t y = 0; y < mLines.size(); ++y) {
            const Cell cell = mCells[1][y];
            const Line &before = plane[std::size_t(cell.first)], &after = plane[std::size_t(cell.first) + 1];
            for (std::size_t z = 0; z < std::size_t(mCorners[2]); ++z)
                mLines[y][std::size_t(x)][z] = mix(before[z], after[z], cell.fraction);
        }
    }
}

} // namespace vdblic
