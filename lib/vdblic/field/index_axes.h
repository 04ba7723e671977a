#pragma once

#include <openvdb/openvdb.h>

namespace vdblic {

/// The linear part of a transform: its columns are the index axes in world space.
[[nodiscard]] inline openvdb::Mat3d indexAxes(const openvdb::math::Transform& transform)
{
    openvdb::Mat3d columns;
    for (int axis = 0; axis < 3; ++axis) {
        openvdb::Vec3d unit(0);
        unit[axis] = 1;
        columns.setCol(axis, transform.baseMap()->applyJacobian(unit));
    }
    return columns;
}

} // namespace vdblic
