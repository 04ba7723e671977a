#include "vdblic/core/grid_instances.h"

#if defined(VDBLIC_LIBRARY_HAS_GRIDS) && defined(VDBLIC_COMPILES_GRIDS)
#undef VDBLIC_GRID_INSTANCE
#define VDBLIC_GRID_INSTANCE(TreeType)                                                                                 \
    template class openvdb::tree::Tree<TreeType::RootNodeType>;                                                        \
    template class openvdb::Grid<TreeType>

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
#elif defined(VDBLIC_LIBRARY_HAS_GRIDS)
// Members that units of this project call and OpenVDB's library does not export. An undefined reference to a member of
// openvdb::Grid or openvdb::tree::Tree is mended by a line here.
template openvdb::DoubleGrid::Ptr openvdb::Grid<openvdb::DoubleTree>::create(openvdb::DoubleTree::Ptr);
template openvdb::Vec3SGrid::Ptr openvdb::Grid<openvdb::Vec3STree>::create(openvdb::Vec3STree::Ptr);
template openvdb::Vec3DGrid::Ptr openvdb::Grid<openvdb::Vec3DTree>::create(openvdb::Vec3DTree::Ptr);
#endif
