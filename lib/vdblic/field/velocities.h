#pragma once

#include "vdblic/field/period.h"
#include "vdblic/field/units.h"

#include <openvdb/openvdb.h>

#include <array>
#include <cstddef>

namespace vdblic {

/// The largest magnitude of stored velocities along each axis.
struct StoredSpeeds {
    std::array<float, 3> along{};
    [[nodiscard]] float operator[](std::size_t axis) const { return along[axis]; }
};

/// The stored velocities of one frame, and their conversion to a space and time unit. In a periodic box they are those
/// of period.wrapped() voxels.
template<Space kSpace, Per kTime>
struct Velocities {
    const openvdb::Vec3STree& stored; ///< on voxel centres, in any unit
    FromStored<kSpace, kTime> unit;
    Period period{}; ///< in stored voxels

    [[nodiscard]] Velocities operator*(double factor) const { return {stored, unit * factor, period}; }
};

} // namespace vdblic
