#pragma once

#include <openvdb/openvdb.h>

namespace vdblic {

/// The 4 × 4 matrix of a linear transform from index to world space, for row vectors, as OpenVDB has it.
///
/// Unlike openvdb::math::MapBase::getAffineMap(), which throws on tiny voxels, it takes voxels of any size.
[[nodiscard]] inline openvdb::Mat4d affineRows(const openvdb::math::Transform& transform)
{
    const openvdb::math::MapBase& map = *transform.baseMap();
    openvdb::Mat4d rows = openvdb::Mat4d::identity();
    const openvdb::Vec3d origin = map.applyMap(openvdb::Vec3d(0));
    for (int i = 0; i < 3; ++i) {
        openvdb::Vec3d unit(0);
        unit[i] = 1;
        const openvdb::Vec3d row = map.applyJacobian(unit);
        for (int j = 0; j < 3; ++j)
            rows(i, j) = row[j];
        rows(3, i) = origin[i];
    }
    return rows;
}

} // namespace vdblic
