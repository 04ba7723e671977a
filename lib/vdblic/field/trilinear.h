#pragma once

#include <openvdb/openvdb.h>

#include <type_traits>

namespace vdblic {

/// The trilinear value at a position, over the active ones of the eight corners, with weights normalised to 1; 0
/// without such a corner. At a voxel's centre exactly its value.
/// @param values   an accessor of a tree of floats or of vectors of floats
/// @param position in its index space
template<typename Accessor>
[[nodiscard]] typename Accessor::ValueType valueAt(const Accessor& values, const openvdb::Vec3d& position)
{
    using Value = typename Accessor::ValueType;
    using Sum = std::conditional_t<std::is_same_v<Value, float>, double, openvdb::Vec3d>;
    const openvdb::Coord base = openvdb::Coord::floor(position);
    const openvdb::Vec3d fraction = position - base.asVec3d();
    Sum sum(0);
    double weights = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const openvdb::Coord step(corner >> 2, corner >> 1 & 1, corner & 1);
        Value value(0);
        if (!values.probeValue(base + step, value)) continue;
        double weight = 1;
        for (int axis = 0; axis < 3; ++axis)
            weight *= step[axis] ? fraction[axis] : 1 - fraction[axis];
        sum += weight * Sum(value);
        weights += weight;
    }
    return weights > 0 ? Value(sum / weights) : Value(0);
}

} // namespace vdblic
