#include "vdblic/core/grid_instances.h"

#if defined(VDBLIC_LIBRARY_HAS_GRIDS) && defined(VDBLIC_COMPILES_GRIDS)
#define VDBLIC_GRID(TreeType)                                                                                          \
    template class openvdb::tree::Tree<TreeType::RootNodeType>;                                                        \
    template class openvdb::Grid<TreeType>;

VDBLIC_FOR_GRID_TREES(VDBLIC_GRID)
#elif defined(VDBLIC_LIBRARY_HAS_GRIDS)
// Members used here that OpenVDB's library does not export. On an undefined reference to a member of openvdb::Grid or
// openvdb::tree::Tree, add a line.
template openvdb::DoubleGrid::Ptr openvdb::Grid<openvdb::DoubleTree>::create(openvdb::DoubleTree::Ptr);
template openvdb::Vec3SGrid::Ptr openvdb::Grid<openvdb::Vec3STree>::create(openvdb::Vec3STree::Ptr);
template openvdb::Vec3DGrid::Ptr openvdb::Grid<openvdb::Vec3DTree>::create(openvdb::Vec3DTree::Ptr);
#endif
