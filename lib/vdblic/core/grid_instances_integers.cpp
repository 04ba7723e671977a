#include "vdblic/core/grid_instances.h"

VDBLIC_GRID_INSTANCE(, openvdb::Int32Tree);
VDBLIC_GRID_INSTANCE(, openvdb::Int64Tree);
