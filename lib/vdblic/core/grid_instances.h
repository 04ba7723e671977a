#pragma once

#include <openvdb/openvdb.h>
#include <openvdb/points/PointDataGrid.h>

/// OpenVDB's grids and trees that are not compiled in every unit that names them. Their virtual functions, most of what
/// such a unit would take to compile, are in OpenVDB's library; grid_instances.cpp has what that leaves out, or all.
/// Precompiled into every unit of this project. Without VDBLIC_LIBRARY_HAS_GRIDS every unit compiles what it uses.
#ifdef VDBLIC_LIBRARY_HAS_GRIDS
#define VDBLIC_GRID_INSTANCE(TreeType)                                                                                 \
    extern template class openvdb::tree::Tree<TreeType::RootNodeType>;                                                 \
    extern template class openvdb::Grid<TreeType>

VDBLIC_GRID_INSTANCE(openvdb::FloatTree);
VDBLIC_GRID_INSTANCE(openvdb::DoubleTree);
VDBLIC_GRID_INSTANCE(openvdb::Vec3STree);
VDBLIC_GRID_INSTANCE(openvdb::Vec3DTree);
VDBLIC_GRID_INSTANCE(openvdb::Vec3ITree);
VDBLIC_GRID_INSTANCE(openvdb::Int32Tree);
VDBLIC_GRID_INSTANCE(openvdb::Int64Tree);
VDBLIC_GRID_INSTANCE(openvdb::BoolTree);
VDBLIC_GRID_INSTANCE(openvdb::MaskTree);
VDBLIC_GRID_INSTANCE(openvdb::points::PointDataTree);
#endif
