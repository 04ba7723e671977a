#include "bench/engine/advance_all.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>

namespace vdblic::bench {

VDBLIC_KERNEL void advanceAll(const VelocityField& field, const PathlineParams& params, PathBatch& batch, double& sink)
{
    const Domain& domain = field.domain();
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf) {
        const openvdb::Coord origin = domain.origin(leaf);
        const Bricks::Window window = field.window(origin);
        for (int row = 0; row < 64; ++row) {
            batch.lanes = domain.mask(leaf).getWord<std::uint8_t>(openvdb::Index(row));
            if (batch.lanes == 0) continue;
            batch.position = {broadcast8(float(origin[0] + (row >> 3))), broadcast8(float(origin[1] + (row & 7))),
                              Float8{0, 1, 2, 3, 4, 5, 6, 7} + float(origin[2])};
            batch.slope = field.sample(window, batch.position, Float8{}, Vector8{}, batch.lanes);
            advancePaths(field, window, params, batch);
            sink += double(batch.position.x[0]);
        }
    }
}

} // namespace vdblic::bench
