#pragma once

#include <openvdb/openvdb.h>
#include <openvdb/points/PointDataGrid.h>

/// Grids and trees of OpenVDB that are compiled once, in grid_instances_*.cpp, not in every unit that names them: their
/// virtual functions are most of what such a unit would take to compile. Precompiled into every unit of this project.
#define VDBLIC_GRID_INSTANCE(prefix, TreeType)                                                                         \
    prefix template class openvdb::tree::Tree<TreeType::RootNodeType>;                                                 \
    prefix template class openvdb::Grid<TreeType>

VDBLIC_GRID_INSTANCE(extern, openvdb::FloatTree);
VDBLIC_GRID_INSTANCE(extern, openvdb::DoubleTree);
VDBLIC_GRID_INSTANCE(extern, openvdb::Vec3STree);
VDBLIC_GRID_INSTANCE(extern, openvdb::Vec3DTree);
VDBLIC_GRID_INSTANCE(extern, openvdb::Vec3ITree);
VDBLIC_GRID_INSTANCE(extern, openvdb::Int32Tree);
VDBLIC_GRID_INSTANCE(extern, openvdb::Int64Tree);
VDBLIC_GRID_INSTANCE(extern, openvdb::BoolTree);
VDBLIC_GRID_INSTANCE(extern, openvdb::MaskTree);
VDBLIC_GRID_INSTANCE(extern, openvdb::points::PointDataTree);
