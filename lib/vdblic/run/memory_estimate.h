#pragma once

#include "vdblic/lic/texture_method.h"

#include <openvdb/openvdb.h>

namespace vdblic {

struct AdvectParams;
struct FieldDomain;
struct StreakShape;

/// The memory that a run takes at its peak [bytes], by its first frame. Fitted to measured runs: within a quarter of
/// them for domains of full leaves.
[[nodiscard]] double advectBytes(const AdvectParams& params, const FieldDomain& first);

/// The same for a method that looks back. @param velocity, texture voxels of their leaves
[[nodiscard]] double backwardBytes(TextureMethod method, double velocity, double texture);

/// What a run of streaks takes.
struct StreakCost {
    double bytes;           ///< as advectBytes()
    double secondsPerFrame; ///< of processor time
};
/// Fitted to measured runs as advectBytes() is. @param voxels of the velocity, in `box`  @param leaves of the velocity
[[nodiscard]] StreakCost streakCost(const StreakShape& shape, double voxels, double leaves,
                                    const openvdb::CoordBBox& box);

/// The same for a run with default parameters. @param voxels of the velocity's leaves
[[nodiscard]] double advectBytes(double voxels);

} // namespace vdblic
