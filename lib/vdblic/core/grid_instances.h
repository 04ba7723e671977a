#pragma once

#include <openvdb/openvdb.h>
#include <openvdb/points/PointDataGrid.h>

/// OpenVDB's grids and trees that are not compiled in every unit that names them. Their virtual functions, most of what
/// such a unit would take to compile, are in OpenVDB's library; grid_instances.cpp has what that leaves out, or all.
/// Precompiled into every unit of this project. Without VDBLIC_LIBRARY_HAS_GRIDS every unit compiles what it uses.
#ifdef VDBLIC_LIBRARY_HAS_GRIDS
#define VDBLIC_FOR_GRID_TREES(INSTANCE)                                                                                \
    INSTANCE(openvdb::FloatTree)                                                                                       \
    INSTANCE(openvdb::DoubleTree)                                                                                      \
    INSTANCE(openvdb::Vec3STree)                                                                                       \
    INSTANCE(openvdb::Vec3DTree)                                                                                       \
    INSTANCE(openvdb::Vec3ITree)                                                                                       \
    INSTANCE(openvdb::Int32Tree)                                                                                       \
    INSTANCE(openvdb::Int64Tree)                                                                                       \
    INSTANCE(openvdb::BoolTree)                                                                                        \
    INSTANCE(openvdb::MaskTree)                                                                                        \
    INSTANCE(openvdb::points::PointDataTree)
#define VDBLIC_EXTERN_GRID(TreeType)                                                                                   \
    extern template class openvdb::tree::Tree<TreeType::RootNodeType>;                                                 \
    extern template class openvdb::Grid<TreeType>;

VDBLIC_FOR_GRID_TREES(VDBLIC_EXTERN_GRID)
#endif
