#pragma once

#include <openvdb/openvdb.h>

namespace vdblic::compare {

/// The types of grids whose voxels are compared: every type that OpenVDB 10 reads, except points and point indices.
using GridTypes =
    openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid, openvdb::Int64Grid,
                      openvdb::BoolGrid, openvdb::MaskGrid, openvdb::Vec3SGrid, openvdb::Vec3DGrid, openvdb::Vec3IGrid>;

} // namespace vdblic::compare
