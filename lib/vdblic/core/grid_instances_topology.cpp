#include "vdblic/core/grid_instances.h"

VDBLIC_GRID_INSTANCE(, openvdb::BoolTree);
VDBLIC_GRID_INSTANCE(, openvdb::MaskTree);
