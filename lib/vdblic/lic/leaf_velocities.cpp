#include "vdblic/lic/leaf_velocities.h"

#include <cmath>

namespace vdblic {

LeafVelocities::LeafVelocities(const VelocityLevel& level, const Refinement& refinement, const openvdb::Coord& origin)
    : mToStep(level.toStep), mIsRefined(!refinement.isNone())
{
    if (!mIsRefined) {
        mLeaf = level.velocities.probeConstLeaf(origin);
        if (!mLeaf && !level.velocities.probeValue(origin, mConstant)) mConstant = openvdb::Vec3f(0);
        return;
    }
    openvdb::Coord first;
    std::array<int, 3> corners{}; // of cells, along each axis
    for (int axis = 0; axis < 3; ++axis) {
        const auto position = [&](int voxel) {
            return float(origin[axis] + voxel) * refinement.scale(axis) + refinement.shift(axis);
        };
        first[axis] = int(std::floor(position(0)));
        for (int voxel = 0; voxel < LeafVoxel::kDim; ++voxel) {
            const float cell = std::floor(position(voxel));
            mCells[std::size_t(axis)][std::size_t(voxel)] = {int(cell) - first[axis], position(voxel) - cell};
        }
        corners[std::size_t(axis)] = mCells[std::size_t(axis)].back().first + 2;
    }
    for (auto& plane : mRecords) {
        for (auto& line : plane)
            line.fill(Float4{});
    }
    const openvdb::tree::ValueAccessor<const openvdb::Vec3STree> values(level.velocities);
    for (int x = 0; x < corners[0]; ++x) {
        for (int y = 0; y < corners[1]; ++y) {
            for (int z = 0; z < corners[2]; ++z) {
                openvdb::Vec3f value;
                if (!values.probeValue(first.offsetBy(x, y, z), value)) continue;
                mRecords[std::size_t(x)][std::size_t(y)][std::size_t(z)] = Float4{value[0], value[1], value[2], 1};
            }
        }
    }
}

} // namespace vdblic
