#include "vdblic/core/grid_instances.h"

VDBLIC_GRID_INSTANCE(, openvdb::points::PointDataTree);
