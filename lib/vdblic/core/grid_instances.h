#pragma once

#include <openvdb/openvdb.h>
#include <openvdb/points/PointDataGrid.h>

/// OpenVDB's grids and trees that are not compiled in every unit that names them. Their virtual functions, most of what
/// such a unit would take to compile, are in OpenVDB's library; grid_instances.cpp has what that leaves out, or all.
/// Precompiled into every unit of this project. Without VDBLIC_LIBRARY_HAS_GRIDS every unit compiles what it uses.
#ifdef VDBLIC_LIBRARY_HAS_GRIDS
#define VDBLIC_GRID_INSTANCE(how, TreeType)                                                                            \
    how template class openvdb::tree::Tree<TreeType::RootNodeType>;                                                    \
    how template class openvdb::Grid<TreeType>;
#define VDBLIC_GRID_INSTANCES(how)                                                                                     \
    VDBLIC_GRID_INSTANCE(how, openvdb::FloatTree)                                                                      \
    VDBLIC_GRID_INSTANCE(how, openvdb::DoubleTree)                                                                     \
    VDBLIC_GRID_INSTANCE(how, openvdb::Vec3STree)                                                                      \
    VDBLIC_GRID_INSTANCE(how, openvdb::Vec3DTree)                                                                      \
    VDBLIC_GRID_INSTANCE(how, openvdb::Vec3ITree)                                                                      \
    VDBLIC_GRID_INSTANCE(how, openvdb::Int32Tree)                                                                      \
    VDBLIC_GRID_INSTANCE(how, openvdb::Int64Tree)                                                                      \
    VDBLIC_GRID_INSTANCE(how, openvdb::BoolTree)                                                                       \
    VDBLIC_GRID_INSTANCE(how, openvdb::MaskTree)                                                                       \
    VDBLIC_GRID_INSTANCE(how, openvdb::points::PointDataTree)

VDBLIC_GRID_INSTANCES(extern)
#endif
