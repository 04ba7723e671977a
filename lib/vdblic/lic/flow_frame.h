#pragma once

#include "vdblic/field/domain.h"

#include <openvdb/openvdb.h>

#include <memory>

namespace vdblic {

/// One frame of the flow: its domain, and its velocity.
struct FlowFrame {
    std::shared_ptr<const Domain> domain;
    openvdb::Vec3SGrid::ConstPtr velocities;
    openvdb::Mat3d toWorldPerSecond; ///< stored value → world units per second
};

} // namespace vdblic
