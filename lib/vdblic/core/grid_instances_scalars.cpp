#include "vdblic/core/grid_instances.h"

VDBLIC_GRID_INSTANCE(, openvdb::FloatTree);
VDBLIC_GRID_INSTANCE(, openvdb::DoubleTree);
