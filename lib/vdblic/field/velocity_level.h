#pragma once

#include <openvdb/openvdb.h>

namespace vdblic {

/// One frame's velocities and their conversion to voxels per step.
struct VelocityLevel {
    const openvdb::Vec3STree& velocities; ///< on voxel centres, in any unit
    openvdb::Mat3d toStep;                ///< stored value → voxels per step, in index space
};

} // namespace vdblic
