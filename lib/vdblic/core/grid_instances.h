#pragma once

#include <openvdb/openvdb.h>
#include <openvdb/points/PointDataGrid.h>

/// Grids and trees of OpenVDB that are not instantiated in every unit. OpenVDB's library has their virtual functions,
/// most of the compile time; grid_instances.cpp has the missing ones, or all. Part of the precompiled header. Without
/// VDBLIC_LIBRARY_HAS_GRIDS each unit instantiates its own.
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
