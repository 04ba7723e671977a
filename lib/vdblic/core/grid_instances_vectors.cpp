#include "vdblic/core/grid_instances.h"

VDBLIC_GRID_INSTANCE(, openvdb::Vec3STree);
VDBLIC_GRID_INSTANCE(, openvdb::Vec3DTree);
VDBLIC_GRID_INSTANCE(, openvdb::Vec3ITree);
